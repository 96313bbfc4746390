// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/mavlink_interface/servo_map.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <string>

namespace cas::sim {
namespace {

constexpr double kShortest_us = 500;
constexpr double kLongest_us = 2500;

ServoRange parse_range(const base::ConfigNode& node, const ServoRange& usual) {
  ServoRange range;
  range.min_us = node.get_in("min_us", usual.min_us, kShortest_us, kLongest_us);
  range.trim_us = node.get_in("trim_us", usual.trim_us, kShortest_us, kLongest_us);
  range.max_us = node.get_in("max_us", usual.max_us, kShortest_us, kLongest_us);
  const bool ordered = range.min_us < range.trim_us && range.trim_us < range.max_us;
  if (!ordered) node.fail("min_us, trim_us and max_us do not rise");
  return range;
}

/// Index from 0 of a key "1" to "16".
std::size_t parse_number(const std::string& key, const base::ConfigNode& value) {
  int number = 0;
  const auto [end, error] = std::from_chars(key.data(), key.data() + key.size(), number);
  const bool whole = error == std::errc() && end == key.data() + key.size();
  if (!whole || number < 1 || number > base::kMaxOutputs) value.fail("is no output from 1 to 16");
  return static_cast<std::size_t>(number - 1);
}

std::array<std::uint16_t, 16> pulses(const mavlink::common::ServoOutputRaw& p) {
  return {p.servo1_raw,  p.servo2_raw,  p.servo3_raw,  p.servo4_raw,  p.servo5_raw,  p.servo6_raw,
          p.servo7_raw,  p.servo8_raw,  p.servo9_raw,  p.servo10_raw, p.servo11_raw, p.servo12_raw,
          p.servo13_raw, p.servo14_raw, p.servo15_raw, p.servo16_raw};
}

double rotor_output(double pulse_us, const ServoRange& range) {
  return std::clamp((pulse_us - range.min_us) / (range.max_us - range.min_us), 0.0, 1.0);
}

double servo_output(double pulse_us, const ServoRange& range) {
  const double side_us =
      pulse_us >= range.trim_us ? range.max_us - range.trim_us : range.trim_us - range.min_us;
  return std::clamp((pulse_us - range.trim_us) / side_us, -1.0, 1.0);
}

}  // namespace

ServoMap::ServoMap(const base::ConfigNode& node, const base::Vehicle& vehicle) {
  std::array<ServoRange, base::kMaxOutputs> ranges;
  ranges.fill(parse_range(node, {}));
  if (const auto channels = node.find("channels")) {
    for (const auto& [key, value] : channels->entries()) {
      ServoRange& range = ranges[parse_number(key, value)];
      range = parse_range(value, range);
    }
  }
  const auto add = [&](int number, bool is_rotor) {
    outputs_.push_back({number, is_rotor, ranges[static_cast<std::size_t>(number)]});
  };
  for (const base::Rotor& rotor : vehicle.rotors) {
    add(rotor.output, true);
    if (rotor.tilt) add(rotor.tilt->output, false);
  }
  if (!vehicle.aero) return;
  for (const base::ControlSurface& surface : vehicle.aero->surfaces) add(surface.output, false);
}

MotorCommand ServoMap::to_motor_command(const mavlink::common::ServoOutputRaw& packet) const {
  MotorCommand command;
  command.kind = MotorCommand::Kind::kMotorOutputs;
  command.values.setZero(base::kMaxOutputs);
  const auto all_us = pulses(packet);
  for (const Output& output : outputs_) {
    const double pulse_us = all_us[static_cast<std::size_t>(output.number)];
    if (pulse_us <= 0) continue;
    command.values[output.number] = output.is_rotor ? rotor_output(pulse_us, output.range)
                                                    : servo_output(pulse_us, output.range);
    command.armed |= output.is_rotor && command.values[output.number] > 0;
  }
  return command;
}

}  // namespace cas::sim
