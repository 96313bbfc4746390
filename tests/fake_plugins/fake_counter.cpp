// SPDX-License-Identifier: BSD-3-Clause
#include <cstdio>
#include <memory>

#include "libsim/api/messages.hpp"
#include "libsim/api/plugin.hpp"

namespace {

using namespace cas;

/// Publishes on `imu` values derived from its seed and the steps, and counts its calls.
class FakeCounter final : public sim::Plugin {
 public:
  void configure(sim::PluginContext& context, const base::ConfigNode& params) override {
    offset_ = params.get("offset", 0.0);
    seed_ = context.seed();
    vehicle_ = context.vehicle_id();
    imu_ = context.bus().advertise<sim::ImuSample>(
        context.topic(params.get<std::string>("topic", "imu")));
    file_ = context.output_dir() / ("finished_" + context.vehicle_name());
  }
  void pre_step(const sim::StepInfo& step, sim::World& world) override {
    ++pre_;
    world.add_wrench(vehicle_, {{1e-3 * static_cast<double>(step.index % 7), 0, 0}, {0, 0, 0}});
  }
  void post_step(const sim::StepInfo& step, const sim::World& world) override {
    ++post_;
    sim::ImuSample sample;
    sample.time = step.time;
    sample.specific_force_B = world.state(vehicle_).a_WB - world.environment(vehicle_).gravity_W;
    sample.angular_rate_B.x() = offset_ + static_cast<double>(seed_ % 1000);
    imu_.publish(sample);
  }
  void reset() override { pre_ = post_ = 0; }
  void finish() override {
    if (std::FILE* file = std::fopen(file_.c_str(), "w")) std::fclose(file);
  }
  std::string stats_json() const override {
    return "{\"pre\":" + std::to_string(pre_) + ",\"post\":" + std::to_string(post_) +
           ",\"endpoint\":\"fake 1\"}";
  }

 private:
  double offset_ = 0;
  std::uint64_t seed_ = 0;
  sim::VehicleId vehicle_{};
  std::uint64_t pre_ = 0;
  std::uint64_t post_ = 0;
  std::filesystem::path file_;
  sim::Publisher<sim::ImuSample> imu_;
};

}  // namespace

CAS_PLUGIN(FakeCounter, "fake_counter")
