// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/api/plugin.hpp"

namespace {

/// Needs `rate_hz` and takes no other key.
class RefusesParams final : public cas::sim::Plugin {
 public:
  void configure(cas::sim::PluginContext&, const cas::base::ConfigNode& params) override {
    params.require_in("rate_hz", 1, 1000);
  }
  void reset() override {}
};

}  // namespace

CAS_PLUGIN(RefusesParams, "fake_refuses_params")
