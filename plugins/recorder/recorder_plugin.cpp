// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/config/sensor_names.hpp"
#include "base/time/rate_gate.hpp"
#include "libsim/api/messages.hpp"
#include "libsim/api/plugin.hpp"
#include "libsim/api/point_cloud.hpp"
#include "plugins/common/noise_params.hpp"
#include "plugins/common/result_path.hpp"
#include "plugins/recorder/csv_writer.hpp"
#include "plugins/recorder/flight_csv.hpp"
#include "plugins/recorder/flight_ulog.hpp"

namespace cas::sim {
namespace {

/// Writes the vehicle's true motion to `file` (CSV) at `rate_hz` from time zero on; every sample of
/// every sensor to CSV files in `sensor_dir`; all of it to `ulog`; some returns of each lidar to
/// `clouds`. All but the first are optional.
class RecorderPlugin final : public Plugin {
 public:
  void configure(PluginContext& context, const base::ConfigNode& params) override {
    vehicle_ = context.vehicle_id();
    rotors_ = context.vehicle().rotor_count();
    commands_ = command_values(context.vehicle());
    has_airspeed_ = context.bus().is_advertised(context.topic("airspeed"));
    if (const auto& aero = context.vehicle().aero) {
      surfaces_ = static_cast<int>(aero->surfaces.size());
    }
    further_ = further_sensors(context);
    deflections_ = neutral();
    speeds_ = standing();
    rate_ = base::RateGate(parse_rate(params, base::to_seconds(context.step())));
    output_ = context.output_dir();
    truth_file_ = result_path(params.at("file"));
    if (const auto folder = params.find("sensor_dir")) sensor_dir_ = result_path(*folder);
    if (const auto file = params.find("ulog")) ulog_file_ = result_path(*file);
    while (context.bus().is_advertised(context.topic(lidar_topic(lidars_ + 1)))) ++lidars_;
    if (const auto file = params.find("clouds"); file && lidars_ > 0) {
      clouds_file_ = result_path(*file);
    }
    open();
    subscribe(context);
  }

  void pre_step(const StepInfo& step, World& world) override {
    now_ = step.time;
    if (step.index == 0) write_truth(step.time, world);
  }

  void post_step(const StepInfo& step, const World& world) override {
    if (!rate_.due(step.time)) return;
    write_truth(step.time, world);
    if (ulog_) ulog_->write(speeds_);
  }

  void reset() override {
    finish();  // or a buffer would end up in the new file
    open();
    rate_.reset();
    speeds_ = standing();
    deflections_ = neutral();
    now_ = {};
  }

  void finish() override {
    truth_.close();
    if (sensors_) sensors_->close();
    if (ulog_) ulog_->close();
    if (clouds_) clouds_->close();
    sensors_.reset();
    ulog_.reset();
    clouds_.reset();
  }

 private:
  static constexpr double kCloudHz = 2;
  static constexpr std::size_t kMostReturns = 600;  // of a scan

  void open() {
    truth_ = CsvWriter({output_, truth_file_}, truth_header(rotors_, has_airspeed_, surfaces_));
    if (!sensor_dir_.empty()) {
      sensors_.emplace(base::ResultPlace{output_, sensor_dir_}, commands_, has_airspeed_, further_);
    }
    if (!ulog_file_.empty()) {
      ulog_.emplace(base::ResultPlace{output_, ulog_file_}, rotors_, commands_, has_airspeed_,
                    surfaces_);
    }
    if (clouds_file_.empty()) return;
    clouds_.emplace(base::ResultPlace{output_, clouds_file_}, "time_s,east_m,north_m,up_m");
    cloud_rates_.assign(static_cast<std::size_t>(lidars_), base::RateGate(kCloudHz));
  }

  void write_cloud(const PointCloud& scan, int number) {
    if (!clouds_ || !cloud_rates_[static_cast<std::size_t>(number - 1)].due(now_)) return;
    const double time_s = base::to_seconds(now_);
    const auto centimetres = [](float value) { return std::round(100.0 * value) / 100; };
    for (const Eigen::Vector3f& p_W : drawn_points(scan, kMostReturns)) {
      clouds_->row({time_s, centimetres(p_W.x()), centimetres(p_W.y()), centimetres(p_W.z())});
    }
  }

  RotorSpeeds standing() const {
    return {.time = {}, .omega_rad_s = base::RotorVector::Zero(rotors_)};
  }

  ActuatorValues neutral() const { return ActuatorValues::Zero(surfaces_.value_or(0)); }

  void write_truth(base::SimTime time, const World& world) {
    const BodyState& state = world.state(vehicle_);
    std::optional<double> airspeed_m_s;
    if (has_airspeed_) airspeed_m_s = true_airspeed_m_s(state, world.environment(vehicle_));
    std::optional<WingTruth> wing;
    if (surfaces_) wing = wing_truth(state, world.environment(vehicle_), deflections_);
    const TruthRow row = truth_row(time, state, speeds_.omega_rad_s, airspeed_m_s, wing);
    truth_.row({row.data(), static_cast<std::size_t>(row.size())});
    if (ulog_) ulog_->write_truth(time, state, airspeed_m_s, wing);
  }

  /// Sensors beside the first of a kind, whose plugins are in front of this one.
  static std::vector<std::string> further_sensors(PluginContext& context) {
    std::vector<std::string> names;
    for (const base::SensorKind& kind : base::kSensorKinds) {
      for (int number = 2; number <= kind.most; ++number) {
        std::string name = base::sensor_name(kind.plugin, number);
        if (context.bus().is_advertised(context.topic(name))) names.push_back(std::move(name));
      }
    }
    return names;
  }

  /// The log has the first sensor of a kind, the CSV files have all.
  template <class Sample>
  void listen(PluginContext& context, const char* topic) {
    for (int number = 1; number <= base::most_sensors(topic); ++number) {
      const std::string name = base::sensor_name(topic, number);
      if (number > 1 && std::ranges::find(further_, name) == further_.end()) continue;
      subscriptions_.push_back(context.bus().subscribe<Sample>(
          context.topic(name),
          [this, number](const Sample& sample) {
            if (sensors_) sensors_->write(sample, number);
            if (ulog_ && number == 1) ulog_->write(sample);
          },
          Need::kOptional));
    }
  }

  void subscribe(PluginContext& context) {
    subscriptions_.push_back(context.bus().subscribe<RotorSpeeds>(
        context.topic("rotor_speeds"), [this](const RotorSpeeds& speeds) { speeds_ = speeds; },
        Need::kOptional));
    subscriptions_.push_back(context.bus().subscribe<SurfaceDeflections>(
        context.topic("surface_deflections"),
        [this](const SurfaceDeflections& each) { deflections_ = each.angle_rad; },
        Need::kOptional));
    for (int number = 1; !clouds_file_.empty() && number <= lidars_; ++number) {
      subscriptions_.push_back(context.bus().subscribe<PointCloud>(
          context.topic(lidar_topic(number)),
          [this, number](const PointCloud& scan) { write_cloud(scan, number); }));
    }
    if (!sensors_ && !ulog_) return;
    listen<ImuSample>(context, "imu");
    listen<GpsSample>(context, "gps");
    listen<MagnetometerSample>(context, "magnetometer");
    listen<BarometerSample>(context, "barometer");
    listen<RangeSample>(context, "rangefinder");
    if (has_airspeed_) listen<AirspeedSample>(context, "airspeed");
    subscriptions_.push_back(context.bus().subscribe<MotorCommand>(
        context.topic("motor_command"),
        [this](const MotorCommand& command) {
          if (sensors_) sensors_->write(now_, command);
          if (ulog_) ulog_->write(now_, command);
        },
        Need::kOptional));
  }

  VehicleId vehicle_{};
  int rotors_ = 0;
  int commands_ = 0;
  std::optional<int> surfaces_;  // of a vehicle with a wing
  int lidars_ = 0;               // whose plugins are in front of this one
  bool has_airspeed_ = false;    // a plugin in front of this one publishes `airspeed`
  std::vector<std::string> further_;
  base::RateGate rate_;
  std::filesystem::path output_;
  std::filesystem::path truth_file_;  // relative to output_, as the next three
  std::filesystem::path sensor_dir_;
  std::filesystem::path ulog_file_;
  std::filesystem::path clouds_file_;
  CsvWriter truth_;
  std::optional<SensorCsv> sensors_;
  std::optional<FlightUlog> ulog_;
  std::optional<CsvWriter> clouds_;
  std::vector<base::RateGate> cloud_rates_;  // of each lidar
  base::SimTime now_;                        // start of the step: when commands are applied
  RotorSpeeds speeds_;
  ActuatorValues deflections_;
  std::vector<Subscription> subscriptions_;
};

}  // namespace
}  // namespace cas::sim

CAS_PLUGIN(cas::sim::RecorderPlugin, "recorder")
