// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/api/plugin.hpp"

namespace {

class Idle final : public cas::sim::Plugin {
 public:
  void configure(cas::sim::PluginContext&, const cas::base::ConfigNode&) override {}
  void reset() override {}
};

}  // namespace

CAS_PLUGIN(Idle, "somebody_else")
