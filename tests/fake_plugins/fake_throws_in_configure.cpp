// SPDX-License-Identifier: BSD-3-Clause
#include <stdexcept>

#include "libsim/api/plugin.hpp"

namespace {

class ThrowsInConfigure final : public cas::sim::Plugin {
 public:
  void configure(cas::sim::PluginContext&, const cas::base::ConfigNode& params) override {
    if (params.get("odd", false)) throw 42;
    throw std::runtime_error("the sensor is not there");
  }
  void reset() override {}
};

}  // namespace

CAS_PLUGIN(ThrowsInConfigure, "fake_throws_in_configure")
