// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/api/messages.hpp"
#include "libsim/api/plugin.hpp"

namespace {

using namespace cas;

/// Subscribes to `imu` and counts.
class FakeListener final : public sim::Plugin {
 public:
  void configure(sim::PluginContext& context, const base::ConfigNode&) override {
    imu_ = context.bus().subscribe<sim::ImuSample>(context.topic("imu"),
                                                   [this](const sim::ImuSample&) { ++heard_; });
  }
  void reset() override { heard_ = 0; }
  std::string stats_json() const override { return "{\"heard\":" + std::to_string(heard_) + "}"; }

 private:
  std::uint64_t heard_ = 0;
  sim::Subscription imu_;
};

}  // namespace

CAS_PLUGIN(FakeListener, "fake_listener")
