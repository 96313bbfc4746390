// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "casd/station/services.hpp"

namespace cas::base {
class ConfigNode;
}

namespace cas::casd {

/// Gains of one control loop; those not given are left alone.
struct GainValues {
  std::optional<double> p;
  std::optional<double> i;
  std::optional<double> d;
};

/// One control loop of one autopilot: the parameters that hold its gains. A loop without an
/// integral or derivative part has no name for it.
struct GainLoop {
  std::string name;
  std::optional<std::string> p;
  std::optional<std::string> i;
  std::optional<std::string> d;
};

/// Why these gains cannot be set on this loop ("loop roll has no I gain; it has P"), or nothing.
std::optional<std::string> unsupported(const GainLoop& loop, const GainValues& values);

/// Loop names to parameter names, per autopilot (config/gains.yaml).
class GainMap {
 public:
  GainMap() = default;
  /// @throws base::ConfigError
  static GainMap load(const std::filesystem::path& file);
  /// The map that ships with the programs; empty where it is not installed.
  static GainMap shipped();
  static GainMap parse(const base::ConfigNode& node);

  /// The loop, or nothing for an autopilot or a name the map does not have.
  const GainLoop* find(Autopilot autopilot, std::string_view loop) const;
  /// In the file's order.
  const std::vector<GainLoop>& loops(Autopilot autopilot) const;
  bool empty() const { return loops_.empty(); }

 private:
  std::map<Autopilot, std::vector<GainLoop>> loops_;
};

}  // namespace cas::casd
