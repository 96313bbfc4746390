// SPDX-License-Identifier: BSD-3-Clause
#include "hils/firmware/first_sign.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <vector>

#include "hils/firmware/companion_station.hpp"

namespace cas::hils {
namespace {

using nlohmann::json;

constexpr std::array kInterfaces{"mavlink_interface", "ardupilot_json"};

/// At the port of the simulator that the firmware itself opens or sends to.
/// @return whether the simulator has one
bool look_at_simulator(const json& stats, const std::string& vehicle, FirstSign& sign,
                       std::vector<std::string>& words) {
  const json plugins = stats.value("plugins", json::object());
  bool has_port = false;
  const auto note = [&](bool came, const std::string& what) {
    has_port = true;
    sign.anything |= came;
    words.push_back(what);
  };
  for (const char* interface : kInterfaces) {
    const auto found = plugins.find(fmt::format("{}@{}", interface, vehicle));
    if (found == plugins.end() || !found->is_object()) continue;
    const std::string endpoint = found->value("endpoint", "");
    if (found->contains("packets")) {
      const auto packets = found->value("packets", std::uint64_t{0});
      note(packets > 0, packets > 0 ? fmt::format("{} packets came to {}", packets, endpoint)
                                    : fmt::format("no packet came to {}", endpoint));
    }
    const json port = found->value("port", json::object());
    if (port.contains("connections")) {
      const bool came = port.value("connections", std::uint64_t{0}) > 0;
      note(came, fmt::format("{} connected to {}", came ? "it" : "nobody", endpoint));
    }
  }
  return has_port;
}

/// @return whether a byte has come
bool look_at_casd(const json& links, bool on_serial_line, std::vector<std::string>& words) {
  bool came = false;
  for (const json& link : links) {
    const std::string name = link.value("name", "");
    const bool serial = link.value("type", "") == "serial";
    if (name.starts_with(CompanionStation::kLink) || serial != on_serial_line) continue;
    const json rx = link.value("rx", json::object());
    const auto bytes = rx.value("bytes", std::uint64_t{0});
    came |= bytes > 0;
    words.push_back(fmt::format(
        "{} on link {} ({})",
        bytes > 0 ? fmt::format("{} bytes and no HEARTBEAT of an autopilot", bytes) : "nothing",
        name, link.value("endpoint", "")));
  }
  return came;
}

/// Whether casd's word for a MAV_TYPE may be a multirotor.
bool is_multirotor(std::string_view type) {
  constexpr std::array<std::string_view, 3> kOthers{"fixed_wing", "rover", "helicopter"};
  return std::ranges::find(kOthers, type) == kOthers.end();
}

}  // namespace

FirstSign first_sign(const json& stats, const json& links, const std::string& vehicle,
                     bool on_serial_line) {
  FirstSign sign;
  std::vector<std::string> words;
  const bool has_port = look_at_simulator(stats, vehicle, sign, words);
  // In software a firmware first meets its simulator; what comes to casd before it may be of
  // others.
  const bool came = look_at_casd(links, on_serial_line, words);
  if (!has_port) sign.anything = came;
  sign.words = fmt::format("{}", fmt::join(words, "; "));
  return sign;
}

std::optional<std::string> mismatch(const VehicleReport& vehicle, std::string_view wanted,
                                    bool has_wing) {
  const bool unknown = wanted.empty() || vehicle.autopilot == "other";
  if (!unknown && vehicle.autopilot != wanted) {
    return fmt::format(
        "the scenario's world is for {}, and the first HEARTBEAT is of {}: start {}, or take a "
        "scenario of {}",
        wanted, vehicle.autopilot, wanted, vehicle.autopilot);
  }
  if (is_multirotor(vehicle.type)) return std::nullopt;
  if (has_wing && vehicle.type == "fixed_wing") return std::nullopt;
  return fmt::format(
      "the scenario's vehicle is a {}, and by its first HEARTBEAT the firmware flies a {}: "
      "start the firmware for {}",
      has_wing ? "plane" : "multirotor", vehicle.type, has_wing ? "planes" : "copters");
}

}  // namespace cas::hils
