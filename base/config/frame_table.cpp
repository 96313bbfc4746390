// SPDX-License-Identifier: BSD-3-Clause
#include "base/config/frame_table.hpp"

#include <algorithm>
#include <cmath>

#include "base/angles.hpp"

namespace cas::base {
namespace {

constexpr double kSameDirection_deg = 20;  // arms need not be a regular star

Frame parse_frame(const ConfigNode& node) {
  Frame frame;
  frame.name = node.require<std::string>("name");
  if (const auto px4 = node.find("px4")) frame.px4_airframe = px4->as<int>();
  if (const auto ardupilot = node.find("ardupilot")) {
    const std::vector<ConfigNode> pair = ardupilot->items();
    if (pair.size() != 2) ardupilot->fail("is [FRAME_CLASS, FRAME_TYPE]");
    frame.ardupilot = {pair[0].as<int>(), pair[1].as<int>()};
  }
  for (const ConfigNode& item : node.at("rotors").items()) {
    const std::vector<ConfigNode> place = item.items();
    if (place.size() != 3) item.fail("is [angle, spin, level]");
    frame.rotors.push_back({place[0].as<double>(), place[1].as<int>(), place[2].as<int>()});
  }
  return frame;
}

/// 1 for the upper rotor of a pair, -1 for the lower, 0 for a single rotor.
int level_of(const Vehicle& vehicle, std::size_t index) {
  if (vehicle.rotors[index].wake) return -1;
  for (const Rotor& rotor : vehicle.rotors) {
    if (rotor.wake && rotor.wake->upper == static_cast<int>(index)) return 1;
  }
  return 0;
}

}  // namespace

bool Frame::fits(const Vehicle& vehicle) const {
  if (vehicle.rotors.size() != rotors.size()) return false;
  for (std::size_t i = 0; i < rotors.size(); ++i) {
    const auto at = std::ranges::find(vehicle.rotors, static_cast<int>(i), &Rotor::output);
    if (at == vehicle.rotors.end()) return false;
    const Rotor& rotor = *at;
    if (rotor.axis_B.z() <= 0) return false;  // the tables tell places and spins from above
    const double angle_deg = degrees(std::atan2(-rotor.position_B_m.y(), rotor.position_B_m.x()));
    if (std::abs(std::remainder(angle_deg - rotors[i].angle_deg, 360)) > kSameDirection_deg) {
      return false;
    }
    if (rotors[i].spin != 0 && rotors[i].spin != rotor.spin) return false;
    const auto index = static_cast<std::size_t>(at - vehicle.rotors.begin());
    if (rotors[i].level != level_of(vehicle, index)) return false;
  }
  return true;
}

std::vector<Frame> load_frames(const std::filesystem::path& file) {
  const ConfigNode node = ConfigNode::load(file);
  if (node.require<int>("schema") != 1) node.at("schema").fail("this program reads schema 1");
  std::vector<Frame> frames;
  for (const ConfigNode& item : node.at("frames").items()) frames.push_back(parse_frame(item));
  node.reject_unused();
  return frames;
}

}  // namespace cas::base
