// SPDX-License-Identifier: BSD-3-Clause
#include <stdexcept>

#include "libsim/api/plugin.hpp"

namespace {

class ThrowsInCreate final : public cas::sim::Plugin {
 public:
  ThrowsInCreate() { throw std::runtime_error("no memory of its own"); }
  void configure(cas::sim::PluginContext&, const cas::base::ConfigNode&) override {}
  void reset() override {}
};

}  // namespace

CAS_PLUGIN(ThrowsInCreate, "fake_throws_in_create")
