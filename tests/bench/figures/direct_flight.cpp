// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/figures/direct_flight.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>
#include <string>

#include "base/angles.hpp"
#include "base/config/config.hpp"
#include "base/config/install_paths.hpp"
#include "base/config/sensor_set.hpp"
#include "base/earth/deg_e7.hpp"
#include "base/earth/frames.hpp"
#include "base/earth/geodesy.hpp"
#include "base/earth/gravity.hpp"
#include "base/earth/magnetic_field.hpp"
#include "hils/programs/ground_station.hpp"
#include "mavlink/common/command_int.hpp"
#include "mavlink/common/command_long.hpp"
#include "mavlink_gen/runtime/codec.hpp"

namespace cas::hils {

using namespace mavlink::common;  // NOLINT: the pilot's messages

namespace {

const base::Geodetic kHome{47.397742, 8.545594, 488.0};
constexpr const char* kVehicle = "iris0";
constexpr float kNotGiven = std::numeric_limits<float>::quiet_NaN();

base::ConfigNode sensor_set(const std::string& name) {
  return base::sensor_set(base::ConfigNode::parse("sensors: " + name, "flight").at("sensors"));
}

fcu::FcuConfig controller_config(const DirectFlightOptions& options) {
  fcu::FcuConfig config;
  config.vehicle = base::Vehicle::load(base::find_config(options.vehicle));
  config.sensors = sensor_set(options.sensors);
  config.decimal_year = base::kUsualYear;
  config.home_hint = kHome;  // so that its frame is that of the truth
  config.line = options.line;
  config.seed = options.seed;
  return config;
}

sim::SimConfig simulator_config(const DirectFlightOptions& options) {
  const double yaw_W_deg = 90 - base::degrees(options.yaw_rad);
  std::string text = fmt::format(
      "schema: 1\n"
      "world: {{gravity_m_s2: {}, ground: true}}\n"
      "home: {{lat_deg: {}, lon_deg: {}, alt_m: {}}}\n"
      "decimal_year: {}\n"
      "step_us: 1000\n"
      "pace: free_run\n"
      "seed: {}\n"
      "vehicles:\n"
      "  - name: {}\n"
      "    vehicle: {}\n"
      "    sensors: {}\n"
      "    pose: {{x_m: 0, y_m: 0, z_m: 0, yaw_deg: {}}}\n"
      "    plugins:\n",
      base::kStandardGravity_m_s2, kHome.lat_deg, kHome.lon_deg, kHome.alt_m, base::kUsualYear,
      options.seed, kVehicle, base::find_config(options.vehicle).string(), options.sensors,
      yaw_W_deg);
  for (const char* plugin : {"motor", "imu", "gps", "magnetometer", "barometer"}) {
    text += fmt::format("      - {{plugin: {}}}\n", plugin);
  }
  if (options.wind_m_s > 0 || options.turbulence_w20_m_s > 0) {
    const std::string turbulence = options.turbulence_w20_m_s > 0
                                       ? fmt::format(", turbulence: {}", options.turbulence_w20_m_s)
                                       : "";
    text += fmt::format("      - {{plugin: wind, mean_m_s: {}, from_deg: 0{}}}\n", options.wind_m_s,
                        turbulence);
  }
  if (options.mass_factor != 1) {
    text += fmt::format("      - {{plugin: fault, faults: [{{at_s: 0, mass_factor: {}}}]}}\n",
                        options.mass_factor);
  }
  text += "      - {plugin: mavlink_interface, transport: bus, system_id: 1, component_id: 200}\n";
  return sim::SimConfig::parse(base::ConfigNode::parse(text, "flight"));
}

}  // namespace

DirectFlight::DirectFlight(const DirectFlightOptions& options)
    : controller_(controller_config(options),
                  [this](auto bytes, auto now) { simulator_->wire().write(bytes, now); }),
      simulator_(std::make_unique<VirtualSimulator>(
          simulator_config(options),
          sim::SimOptions{.output_dir = ".", .plugin_dirs = base::plugin_dirs()},
          std::vector<VirtualSimulator::OnBytes>{
              [this](auto bytes, auto now) { controller_.write(bytes, now); }})) {}

void DirectFlight::advance() {
  const base::RunTime next = std::min(simulator_->next_event(), controller_.next_event(now_));
  now_ = std::max(next, now_ + base::Duration(1));
  if (now_ >= simulator_->next_event()) simulator_->step(now_);
  controller_.run(now_);
}

void DirectFlight::run(double seconds, const std::function<void()>& each) {
  const base::RunTime end = now_ + base::from_seconds(seconds);
  while (now_ < end) {
    const base::SimTime before = simulator_->time();
    advance();
    if (each && simulator_->time() != before) each();
  }
}

bool DirectFlight::run_until(const std::function<bool()>& condition, double at_most_s) {
  const double end = time_s() + at_most_s;
  while (!condition()) {
    if (time_s() >= end) return false;
    run(0.01);
  }
  return true;
}

template <class Message>
void DirectFlight::send(const Message& message) {
  std::array<std::uint8_t, mav::kMaxPacketBytes> buffer{};
  const std::size_t size = mav::encode(message, kGroundStation, sequence_++, buffer);
  controller_.controller().on_packet(mav::view_packet(std::span(buffer).first(size)), now_);
}

bool DirectFlight::take_off(double height_m) {
  constexpr double kPatience_s = 30;
  const auto send_command = [this](MavCmd id, float param1, float param7) {
    CommandLong m{.target_system = 1, .target_component = 1, .command = id, .param1 = param1};
    m.param4 = m.param5 = m.param6 = kNotGiven;
    m.param7 = param7;
    send(m);
  };
  if (!run_until([this] { return status().estimator_ready; }, kPatience_s)) return false;
  send_command(MavCmd::kComponentArmDisarm, 1, 0);
  send_command(MavCmd::kNavTakeoff, 0, static_cast<float>(kHome.alt_m + height_m));
  return status().armed &&
         run_until([this] { return status().landed == fcu::LandedState::kInAir; }, kPatience_s);
}

void DirectFlight::go_to(double north_m, double east_m, double up_m, double yaw_rad) {
  const base::Geodetic place = base::LocalProjection(kHome).to_geodetic({north_m, east_m, -up_m});
  CommandInt m{.target_system = 1,
               .target_component = 1,
               .frame = MavFrame::kGlobalInt,
               .command = MavCmd::kDoReposition,
               .param1 = -1,
               .param2 = 1,
               .param4 = static_cast<float>(yaw_rad),
               .x = base::deg_e7(place.lat_deg),
               .y = base::deg_e7(place.lon_deg),
               .z = static_cast<float>(place.alt_m)};
  send(m);
}

bool DirectFlight::set_param(std::string_view name, double value) {
  return controller_.controller().set_param(name, value);
}

DirectFlight::Truth DirectFlight::truth() const {
  const sim::BodyState& body = simulator_->world().state(sim::VehicleId{0});
  const Eigen::Quaterniond q_ND = base::q_ND_from_q_WB(body.q_WB);
  return {base::swap_WN(body.p_WB), base::swap_WN(body.v_WB), base::euler_rpy(q_ND).z(), q_ND};
}

}  // namespace cas::hils
