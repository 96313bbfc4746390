// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/api/plugin.hpp"

namespace {

using namespace cas;

/// Means to send MAVLink messages and declares none.
class FakeUndeclared final : public sim::Plugin {
 public:
  void configure(sim::PluginContext& context, const base::ConfigNode&) override {
    mavlink_ = context.mavlink();
  }
  void reset() override {}

 private:
  sim::Publisher<sim::MavlinkMessage> mavlink_;
};

}  // namespace

CAS_PLUGIN(FakeUndeclared, "fake_undeclared")
