// SPDX-License-Identifier: BSD-3-Clause
#include "hils/measure/firmware_record.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "mavlink_gen/runtime/sha256.hpp"

namespace cas::hils {

using nlohmann::json;

ParamDigest digest_of(const json& list) {
  std::map<std::string, std::string> values;
  for (const json& param : list) {
    values[param.value("name", "")] = param.value("value", json()).dump();
  }
  mav::Sha256 hash;
  for (const auto& [name, value] : values) {
    const std::string line = name + " " + value + "\n";
    hash.update({reinterpret_cast<const std::uint8_t*>(line.data()), line.size()});
  }
  ParamDigest digest{.count = values.size()};
  for (const std::uint8_t byte : hash.finish()) digest.sha256 += fmt::format("{:02x}", byte);
  return digest;
}

std::optional<double> slowest_hop_us(const json& hops) {
  std::optional<double> slowest;
  for (const json& link : hops) {
    for (const json& route : link.value("routes", json::array())) {
      slowest = std::max(slowest.value_or(0), route.value("p99", 0.0));
    }
  }
  return slowest;
}

void add_losses(const json& links, FirmwareRecord& record) {
  for (const json& link : links) {
    for (const json& count : link.at("tx").at("dropped")) {
      record.dropped += count.get<std::uint64_t>();
    }
    record.lost += link.at("rx").at("lost").get<std::uint64_t>();
  }
}

std::optional<AhrsFigures> ahrs_figures(const nlohmann::json& statistics,
                                        const std::string& vehicle) {
  if (!statistics.is_object()) return std::nullopt;
  const nlohmann::json plugins = statistics.value("plugins", nlohmann::json::object());
  const auto found = plugins.find("external_ahrs@" + vehicle);
  if (found == plugins.end() || !found->is_object()) return std::nullopt;
  const auto count = [&](const char* key) { return found->value(key, std::uint64_t{0}); };
  return AhrsFigures{.sent = count("packets"),
                     .dropped = count("dropped") + count("reader_full"),
                     .late = count("late"),
                     .crc_errors = count("crc_errors"),
                     .longest_gap_ms = found->value("longest_gap_ms", 0.0)};
}

}  // namespace cas::hils
