// SPDX-License-Identifier: BSD-3-Clause
#include "hils/campaign/catalogue.hpp"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <utility>

#include "base/text.hpp"

namespace cas::hils {

namespace {

/// Failures of the bench end by themselves where a campaign says nothing; s.
constexpr double kBenchLasts_s = 5;

constexpr std::string_view kInject = "[MAVLink] FAILURE_TYPE of MAV_CMD_INJECT_FAILURE";

std::vector<Failure> imu_failures() {
  return {{.name = "imu_stuck",
           .meaning = "The sensor repeats its last sample",
           .physics = "specific force and angular rate stay as they are; stamps go on",
           .source = kInject,
           .effects = {"freeze: imu"}},
          {.name = "imu_lost",
           .meaning = "The sensor says nothing any more",
           .physics = "no HIL_SENSOR with specific force and angular rate",
           .source = kInject,
           .effects = {"drop: imu"}},
          {.name = "gyro_bias",
           .meaning = "The gyro's zero has moved, as by heat or a blow",
           .physics = "a constant on the angular rate about the nose",
           .source = "[IEEE 952]: bias",
           .parameters = {{"deg_s", 10, -500, 500}},
           .effects = {"bias: {sensor: imu, angular_rate_deg_s: [$deg_s, 0, 0]}"}},
          {.name = "accel_bias",
           .meaning = "The accelerometer's zero has moved",
           .physics = "a constant on the specific force along the nose",
           .source = "[IEEE 952]: bias",
           .parameters = {{"m_s2", 2, -50, 50}},
           .effects = {"bias: {sensor: imu, specific_force_m_s2: [$m_s2, 0, 0]}"}},
          {.name = "imu_noise",
           .meaning = "Vibration of a loose mount or a broken propeller",
           .physics = "white noise on specific force and angular rate",
           .source = kInject,
           .parameters = {{"m_s2", 15, 0, 200}, {"deg_s", 30, 0, 1000}},
           .effects = {"noise: {sensor: imu, specific_force_m_s2: $m_s2}",
                       "noise: {sensor: imu, angular_rate_deg_s: $deg_s}"}},
          {.name = "imu_saturated",
           .meaning = "The measuring range is too small, or was set wrong",
           .physics = "no component is larger than the end of the range",
           .source = "data sheets: full-scale range",
           .parameters = {{"m_s2", 9, 0, 200}, {"deg_s", 15, 0, 2000}},
           .effects = {"clip: {sensor: imu, specific_force_m_s2: $m_s2}",
                       "clip: {sensor: imu, angular_rate_deg_s: $deg_s}"}},
          {.name = "imu_axes_swapped",
           .meaning = "The driver reads x for y and y for x",
           .physics = "specific force and angular rate with x and y exchanged",
           .source = kInject,
           .effects = {"axes: {sensor: imu, from: [y, x, z]}"}},
          {.name = "imu_late",
           .meaning = "Samples come late, as from a bus that is too busy",
           .physics = "each sample is held back; its stamp is that of its measurement",
           .source = kInject,
           .parameters = {{"by_s", 0.05, 0.001, 5}},
           .effects = {"delay: {sensor: imu, by_s: $by_s}"}},
          {.name = "board_turned",
           .meaning = "The board is mounted, or has slipped, in another direction",
           .physics =
               "IMU and magnetometer read the vehicle's vectors in axes turned about the vertical",
           .source = "PX4: SENS_BOARD_ROT",
           .parameters = {{"yaw_deg", 90, -180, 180}},
           .effects = {"turn: {sensor: imu, rpy_deg: [0, 0, $yaw_deg]}",
                       "turn: {sensor: magnetometer, rpy_deg: [0, 0, $yaw_deg]}"}}};
}

std::vector<Failure> gps_failures() {
  return {{.name = "gps_lost",
           .meaning = "The receiver says nothing any more",
           .physics = "no HIL_GPS",
           .source = kInject,
           .effects = {"drop: gps"}},
          {.name = "gps_no_fix",
           .meaning = "The receiver is jammed: it reports that it has no fix",
           .physics = "fix type 0 and no satellites; position and velocity go on",
           .source = kInject,
           .effects = {"fix: {type: 0, satellites: 0, eph_m: 99, epv_m: 99}"}},
          {.name = "gps_few_satellites",
           .meaning = "Buildings hide most satellites",
           .physics = "four satellites and a large claimed error; position with that error",
           .source = kInject,
           .parameters = {{"error_m", 8, 0, 100}},
           .effects = {"fix: {type: 3, satellites: 4, eph_m: $error_m, epv_m: $error_m}",
                       "noise: {sensor: gps, position_m: $error_m}"}},
          {.name = "gps_frozen",
           .meaning = "The receiver repeats its last fix",
           .physics = "position and velocity stay as they are; stamps go on",
           .source = kInject,
           .effects = {"freeze: gps"}},
          {.name = "gps_jump",
           .meaning = "The position jumps, as by a reflection",
           .physics = "a constant on the position north",
           .source = kInject,
           .parameters = {{"m", 30, -10000, 10000}},
           .effects = {"bias: {sensor: gps, position_m: [$m, 0, 0]}"}},
          {.name = "gps_drift",
           .meaning = "A spoofer leads the position away slowly",
           .physics = "position north goes away at a constant speed; the velocity says so, too",
           .source = "[Kerns]",
           .parameters = {{"m_s", 0.5, -20, 20}},
           .effects = {"drift: {sensor: gps, position_m_s: [$m_s, 0, 0]}",
                       "bias: {sensor: gps, velocity_m_s: [$m_s, 0, 0]}"}},
          {.name = "gps_wrong_velocity",
           .meaning = "The velocity is wrong, the position is not",
           .physics = "a constant on the velocity north",
           .source = kInject,
           .parameters = {{"m_s", 3, -100, 100}},
           .effects = {"bias: {sensor: gps, velocity_m_s: [$m_s, 0, 0]}"}},
          {.name = "gps_late",
           .meaning = "Fixes come late",
           .physics = "each fix is held back; its stamp is that of its measurement",
           .source = kInject,
           .parameters = {{"by_s", 0.8, 0.001, 5}},
           .effects = {"delay: {sensor: gps, by_s: $by_s}"}}};
}

std::vector<Failure> compass_failures() {
  return {{.name = "compass_lost",
           .meaning = "The magnetometer says nothing any more",
           .physics = "no field in HIL_SENSOR",
           .source = kInject,
           .effects = {"drop: magnetometer"}},
          {.name = "compass_stuck",
           .meaning = "The magnetometer repeats its last sample",
           .physics = "the field stays as it is",
           .source = kInject,
           .effects = {"freeze: magnetometer"}},
          {.name = "compass_current",
           .meaning = "Currents of the motors make a field of their own",
           .physics =
               "a field to the right that goes with the power of the rotors; the figure is that of "
               "a hover",
           .source = "ArduPilot: COMPASS_MOTCT",
           .parameters = {{"gauss", 0.15, -5, 5}},
           .effects = {"current: {sensor: magnetometer, field_gauss: [0, $gauss, 0]}"}},
          {.name = "compass_hard_iron",
           .meaning = "A magnet is near: a screw, a payload",
           .physics = "a constant on the field to the right, fixed to the vehicle",
           .source = "PX4, ArduPilot: compass calibration, offsets",
           .parameters = {{"gauss", 0.3, -5, 5}},
           .effects = {"bias: {sensor: magnetometer, field_gauss: [0, $gauss, 0]}"}},
          {.name = "compass_turned",
           .meaning = "The compass is mounted in another direction than its parameter says",
           .physics = "the field in axes turned about the vertical; the IMU is right",
           .source = "PX4: CAL_MAG0_ROT, ArduPilot: COMPASS_ORIENT",
           .parameters = {{"yaw_deg", 90, -180, 180}},
           .effects = {"turn: {sensor: magnetometer, rpy_deg: [0, 0, $yaw_deg]}"}}};
}

std::vector<Failure> barometer_failures() {
  return {{.name = "baro_lost",
           .meaning = "The barometer says nothing any more",
           .physics = "no pressure in HIL_SENSOR",
           .source = kInject,
           .effects = {"drop: barometer"}},
          {.name = "baro_stuck",
           .meaning = "The barometer repeats its last sample",
           .physics = "the pressure stays as it is",
           .source = kInject,
           .effects = {"freeze: barometer"}},
          {.name = "baro_drift",
           .meaning = "The pressure drifts, as by weather or a sensor that warms up",
           .physics = "pressure rises at a constant rate; 12 Pa are 1 m",
           .source = "[ISO 2533]: height by pressure",
           .parameters = {{"pa_s", 3, -1000, 1000}},
           .effects = {"drift: {sensor: barometer, pressure_pa_s: $pa_s}"}},
          {.name = "baro_door",
           .meaning = "A door or a hatch opens: the pressure at the sensor steps",
           .physics = "a constant on the pressure; 12 Pa are 1 m",
           .source = "[ISO 2533]: height by pressure",
           .parameters = {{"pa", -60, -5000, 5000}},
           .effects = {"bias: {sensor: barometer, pressure_pa: $pa}"}},
          {.name = "baro_scaled",
           .meaning = "The driver takes one unit for another: hPa for Pa",
           .physics = "the pressure is multiplied",
           .source = "MAVLink: abs_pressure of HIL_SENSOR is in hPa",
           .parameters = {{"factor", 100, 0.001, 1000}},
           .effects = {"scale: {sensor: barometer, pressure: $factor}"}},
          {.name = "baro_wind",
           .meaning = "Air past the vehicle changes the pressure at the sensor",
           .physics = "a share of the dynamic pressure of the air that meets the vehicle",
           .source = "PX4: EKF2_PCOEF_XP",
           .parameters = {{"coefficient", -1, -10, 10}},
           .effects = {"airflow: {sensor: barometer, pressure_coefficient: $coefficient}"}}};
}

std::vector<Failure> propulsion_failures() {
  return {{.name = "rotor_weak",
           .meaning = "A propeller is chipped",
           .physics = "share of thrust and torque of a rotor at its speed",
           .source = "[HILS] Eq. (1), (2)",
           .parameters = {{"number", 1, 1, 16}, {"share", 0.7, 0, 1}},
           .effects = {"rotor: {number: $number, thrust_share: $share}"}},
          {.name = "rotor_stopped",
           .meaning = "A motor is off",
           .physics = "the speed of a rotor runs down to 0 with the motor's lag",
           .source = "[Mueller-DAndrea]",
           .parameters = {{"number", 1, 1, 16}},
           .effects = {"rotor: {number: $number, stop: true}"}},
          {.name = "rotor_stuck",
           .meaning = "A speed controller holds its last command",
           .physics = "the speed of a rotor stays, whatever is asked",
           .source = kInject,
           .parameters = {{"number", 1, 1, 16}},
           .effects = {"rotor: {number: $number, stuck: true}"}},
          {.name = "esc_reversed",
           .meaning = "A motor turns the other way: two of its phases are exchanged",
           .physics = "thrust and torque of a rotor have the other sign, and a share of their size",
           .source = "[HILS] Eq. (1), (2); the share is assumed",
           .parameters = {{"number", 1, 1, 16}, {"share", -0.5, -1, 0}},
           .effects = {"rotor: {number: $number, thrust_share: $share}"}},
          {.name = "rotors_swapped",
           .meaning = "Two motors are plugged into each other's outputs",
           .physics = "each of two rotors gets the other's command",
           .source = "PX4: actuator test before the first flight",
           .parameters = {{"first", 1, 1, 16}, {"second", 3, 1, 16}},
           .effects = {"swap_rotors: [$first, $second]"}},
          {.name = "battery_sag",
           .part = "battery",
           .meaning = "An old battery sags under load",
           .physics = "share of the voltage: rotors reach that share of the speed that is asked",
           .source = kInject,
           .parameters = {{"share", 0.85, 0, 1}},
           .effects = {"voltage_share: $share"}},
          {.name = "battery_cell_lost",
           .part = "battery",
           .meaning = "One cell of four gives nothing any more",
           .physics = "three quarters of the voltage",
           .source = "cells in series",
           .parameters = {{"share", 0.75, 0, 1}},
           .effects = {"voltage_share: $share"}}};
}

std::vector<Failure> vehicle_failures() {
  return {{.name = "mass_wrong",
           .meaning = "The vehicle is heavier than its controller believes: a payload",
           .physics = "mass and inertia are multiplied",
           .source = "[HILS] Eq. (4)",
           .parameters = {{"factor", 1.3, 0.11, 10}},
           .effects = {"mass_factor: $factor"}},
          {.name = "cg_shifted",
           .meaning = "A payload hangs beside the centre",
           .physics = "surface forces get an arm along the nose",
           .source = "[HILS] Eq. (4)",
           .parameters = {{"m", 0.03, -1, 1}},
           .effects = {"cg_shift_B_m: [$m, 0, 0]"}}};
}

std::vector<Failure> link_failures() {
  constexpr std::string_view kLine = "fcu/line: the serial line's model";
  std::vector<Failure> failures{
      {.name = "line_cut",
       .meaning = "The plug of the controller's serial line is out",
       .physics = "bytes on their way are lost, none enter",
       .source = kLine,
       .effects = {"unplug: fcu"}},
      {.name = "line_loss",
       .meaning = "Packets are lost",
       .physics = "each write is lost with that probability, each way",
       .source = kLine,
       .parameters = {{"share", 0.3, 0, 1}},
       .effects = {"line: {packet_loss: $share}"}},
      {.name = "line_bytes_lost",
       .meaning = "Bytes are lost in bursts, as by a loose contact",
       .physics =
           "Gilbert-Elliott: a burst begins with that probability per byte, and ends with 0.05",
       .source = kLine,
       .parameters = {{"begin", 0.002, 0, 1}},
       .effects = {"line: {burst_begin: $begin, burst_end: 0.05, burst_loss: 1}"}},
      {.name = "line_bits_flipped",
       .meaning = "Bits are flipped by interference",
       .physics = "each bit with that probability; MAVLink's CRC finds most of it",
       .source = kLine,
       .parameters = {{"rate", 5e-4, 0, 0.5}},
       .effects = {"line: {bit_error_rate: $rate}"}},
      {.name = "line_latency",
       .meaning = "The line is slow, as over a radio",
       .physics = "each byte is late by that much, each way",
       .source = kLine,
       .parameters = {{"us", 40000, 0, 5e6}},
       .effects = {"line: {extra_delay_us: $us}"}},
      {.name = "line_baud_mismatch",
       .meaning = "The receiver is set to another baud rate",
       .physics =
           "8N1: the receiver looks at the middle of its own bits; wrong stop bits lose the byte",
       .source = "[Maxim 2141]",
       .parameters = {{"sender", 921600, 1200, 4e6}, {"receiver", 460800, 1200, 4e6}},
       .effects = {"line: {baud: $sender, receiver_baud: $receiver}"}},
      {.name = "packets_duplicated",
       .meaning = "Packets arrive twice, as over two ways",
       .physics = "each write is put on the line twice with that probability",
       .source = kLine,
       .parameters = {{"share", 0.3, 0, 1}},
       .effects = {"line: {packet_duplicate: $share}"}},
      {.name = "packets_reordered",
       .meaning = "Packets overtake each other",
       .physics = "each write comes after the next one with that probability",
       .source = kLine,
       .parameters = {{"share", 0.3, 0, 1}},
       .effects = {"line: {packet_reorder: $share}"}}};
  for (Failure& each : failures) {
    each.of_bench = true;
    each.needs = FailureNeeds::kLineModel;
  }
  return failures;
}

std::vector<Failure> bench_failures() {
  return {
      {.name = "ground_lost",
       .part = "ground",
       .meaning = "The ground station is gone, and casd's own with it",
       .physics = "nothing but the simulator's packets goes to the vehicle",
       .source = kInject,
       .effects = {"silence: ground"},
       .of_bench = true,
       .needs = FailureNeeds::kVirtualClock,
       .unrecorded = true},
      {.name = "casd_killed",
       .meaning = "casd dies, and is started again",
       .physics = "queued and arriving packets of all links are lost until it is back",
       .source = "docs/config.md: restart",
       .effects = {"restart: casd"},
       .of_bench = true},
      {.name = "casd_reloaded",
       .meaning = "casd reads its topology again in flight",
       .physics = "its links and routes are made anew",
       .source = "docs/config.md: reload",
       .effects = {"reload: casd"},
       .of_bench = true,
       .needs = FailureNeeds::kPrograms},
      {.name = "cpu_starved",
       .meaning = "Other programs have the processor",
       .physics = "casd's threads wake up late: log-normal, with that median and 99th percentile",
       .source = "docs/config.md: wake_up",
       .parameters = {{"p50_us", 3000, 1, 1e5}, {"p99_us", 30000, 1, 1e6}},
       .effects = {"starve: {p50_us: $p50_us, p99_us: $p99_us}"},
       .of_bench = true,
       .needs = FailureNeeds::kVirtualClock}};
}

double value_of(const FailureParameter& parameter,
                const std::map<std::string, double, std::less<>>& values) {
  const auto given = values.find(parameter.name);
  return given == values.end() ? parameter.usual : given->second;
}

/// The effect with each $NAME replaced, the longest names first.
std::string filled(std::string_view effect, const Failure& failure,
                   const std::map<std::string, double, std::less<>>& values) {
  std::vector<FailureParameter> parameters = failure.parameters;
  std::ranges::sort(parameters, std::ranges::greater(),
                    [](const FailureParameter& each) { return each.name.size(); });
  std::string text(effect);
  for (const FailureParameter& parameter : parameters) {
    const std::string mark = "$" + std::string(parameter.name);
    for (std::size_t at = text.find(mark); at != std::string::npos; at = text.find(mark)) {
      text.replace(at, mark.size(), fmt::format("{}", value_of(parameter, values)));
    }
  }
  return text;
}

std::string parameter_words(const Failure& failure) {
  return base::joined(failure.parameters, ", ", [](const FailureParameter& each) {
    return fmt::format("{} {:g} ({:g} to {:g})", each.name, each.usual, each.least, each.most);
  });
}

}  // namespace

const std::vector<Failure>& failure_catalogue() {
  static const std::vector<Failure> kCatalogue = [] {
    std::vector<Failure> all;
    const auto add = [&all](std::string_view part, std::vector<Failure> failures) {
      for (Failure& each : failures) {
        if (each.part.empty()) each.part = part;
        all.push_back(std::move(each));
      }
    };
    add("IMU", imu_failures());
    add("GPS", gps_failures());
    add("compass", compass_failures());
    add("barometer", barometer_failures());
    add("rotor", propulsion_failures());
    add("vehicle", vehicle_failures());
    add("line", link_failures());
    add("casd", bench_failures());
    return all;
  }();
  return kCatalogue;
}

const Failure* find_failure(std::string_view name) {
  const auto found = std::ranges::find(failure_catalogue(), name, &Failure::name);
  return found == failure_catalogue().end() ? nullptr : &*found;
}

std::optional<std::string_view> obstacle(const Failure& failure, bool on_board) {
  switch (failure.needs) {
    case FailureNeeds::kNothing:
      break;
    case FailureNeeds::kPrograms:
      if (!on_board) return "needs casd as a program";
      break;
    case FailureNeeds::kVirtualClock:
      if (on_board) return "needs the virtual clock";
      break;
    case FailureNeeds::kLineModel:
      if (on_board) return "needs the emulated line: a real port cannot play it";
      break;
  }
  return std::nullopt;
}

std::string faults_of(const Failure& failure, const std::string& title, const std::string& when,
                      const std::map<std::string, double, std::less<>>& values) {
  const auto given = values.find(kDuration);
  YAML::Node list(YAML::NodeType::Sequence);
  for (const std::string_view effect : failure.effects) {
    YAML::Node fault(YAML::NodeType::Map);
    fault["name"] = title;
    fault["when"] = when;
    if (failure.of_bench) fault["of"] = "truth";
    if (given != values.end() || failure.of_bench) {
      const double lasts_s = given != values.end() ? given->second : kBenchLasts_s;
      fault[std::string(kDuration)] = fmt::format("{}", lasts_s);
    }
    for (const auto& entry : YAML::Load(filled(effect, failure, values))) {
      fault[entry.first.as<std::string>()] = entry.second;
    }
    list.push_back(fault);
  }
  YAML::Emitter text;
  text << YAML::Flow << list;
  return text.c_str();
}

std::string catalogue_text() {
  std::string text;
  for (const Failure& each : failure_catalogue()) {
    text += fmt::format("{} ({}): {}\n  physics: {}\n", each.name, each.part, each.meaning,
                        each.physics);
    if (!each.parameters.empty()) text += fmt::format("  parameters: {}\n", parameter_words(each));
    text += fmt::format("  source: {}\n", each.source);
    if (each.needs == FailureNeeds::kPrograms) {
      text += "  needs casd as a program: a campaign names it and does not fly it\n";
    }
  }
  text += fmt::format(
      "{} failures. Each takes for_s, too: how long it lasts (to the end; {:g} s "
      "where line, ground or casd fail)\n",
      failure_catalogue().size(), kBenchLasts_s);
  return text;
}

std::string catalogue_markdown() {
  std::string text =
      "| failure | part | what has gone wrong | physics | parameters | source |\n"
      "|---|---|---|---|---|---|\n";
  for (const Failure& each : failure_catalogue()) {
    const std::string words = parameter_words(each);
    text += fmt::format("| `{}` | {} | {} | {} | {} | {} |\n", each.name, each.part, each.meaning,
                        each.physics, words.empty() ? "-" : words, each.source);
  }
  return text;
}

}  // namespace cas::hils
