// SPDX-License-Identifier: BSD-3-Clause
#include <filesystem>
#include <string>

#include "base/rate_gate.hpp"
#include "libsim/api/messages.hpp"
#include "libsim/api/plugin.hpp"
#include "plugins/common/noise_params.hpp"
#include "plugins/recorder/csv_writer.hpp"
#include "plugins/recorder/truth_row.hpp"

namespace cas::sim {
namespace {

/// Writes the vehicle's true motion to a CSV file, from time zero on.
class RecorderPlugin final : public Plugin {
 public:
  void configure(PluginContext& context, const base::ConfigNode& params) override {
    vehicle_ = context.vehicle_id();
    rate_ = base::RateGate(parse_rate(params, base::to_seconds(context.step())));
    file_ = context.output_dir() / params.require<std::string>("file");
    truth_ = CsvWriter(file_, kTruthHeader);
    rotors_ = context.bus().subscribe<RotorSpeeds>(
        context.topic("rotor_speeds"),
        [this](const RotorSpeeds& speeds) { omega_ = speeds.omega_rad_s; }, Need::kOptional);
  }

  void pre_step(const StepInfo& step, World& world) override {
    if (step.index == 0) write(step.time, world);
  }

  void post_step(const StepInfo& step, const World& world) override {
    if (rate_.due(step.time)) write(step.time, world);
  }

  void reset() override {
    truth_.close();  // or its buffer would end up in the new file
    truth_ = CsvWriter(file_, kTruthHeader);
    rate_.reset();
    omega_.setZero();
  }

  void finish() override { truth_.close(); }

 private:
  void write(base::SimTime time, const World& world) {
    truth_.row(truth_row(time, world.state(vehicle_), omega_));
  }

  VehicleId vehicle_{};
  base::RateGate rate_;
  std::filesystem::path file_;
  CsvWriter truth_;
  Eigen::Vector4d omega_ = Eigen::Vector4d::Zero();
  Subscription rotors_;
};

}  // namespace
}  // namespace cas::sim

CAS_PLUGIN(cas::sim::RecorderPlugin, "recorder")
