// SPDX-License-Identifier: BSD-3-Clause
#include "hils/replay/truth_columns.hpp"

#include <array>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "hils/measure/column.hpp"

namespace cas::hils {

namespace {

constexpr double kPeriod_s = 0.02;

/// Name in the record, and the smallest visible step.
struct Column {
  std::string_view name;
  double step;
};
constexpr std::array<Column, TruthColumns::kMotion> kColumns{{{"t", 0.001},
                                                              {"x", 0.001},
                                                              {"y", 0.001},
                                                              {"z", 0.001},
                                                              {"vx", 0.002},
                                                              {"vy", 0.002},
                                                              {"vz", 0.002},
                                                              {"roll", 0.0005},
                                                              {"pitch", 0.0005},
                                                              {"yaw", 0.0005},
                                                              {"p", 0.002},
                                                              {"q", 0.002},
                                                              {"r", 0.002}}};
constexpr double kRotorStep_rad_s = 1;
constexpr double kSurfaceStep_rad = 0.002;

}  // namespace

void TruthColumns::add(std::span<const double> row, std::span<const double> deflections) {
  if (row.size() < kMotion || row.front() < next_s_) return;
  next_s_ = row.front() + kPeriod_s - 1e-6;
  if (columns_.empty()) columns_.resize(row.size());
  for (std::size_t i = 0; i < columns_.size(); ++i) {
    columns_[i].push_back(i < row.size() ? row[i] : 0);
  }
  surfaces_.resize(deflections.size());
  for (std::size_t i = 0; i < deflections.size(); ++i) surfaces_[i].push_back(deflections[i]);
}

nlohmann::ordered_json TruthColumns::json() const {
  if (columns_.empty()) return nullptr;
  nlohmann::ordered_json truth;
  for (std::size_t i = 0; i < columns_.size(); ++i) {
    const bool is_rotor = i >= kMotion;
    const std::string name =
        is_rotor ? "rotor" + std::to_string(i - kMotion + 1) : std::string(kColumns[i].name);
    truth[name] = column_json(columns_[i], is_rotor ? kRotorStep_rad_s : kColumns[i].step);
  }
  for (std::size_t i = 0; i < surfaces_.size(); ++i) {
    truth["surface" + std::to_string(i + 1)] = column_json(surfaces_[i], kSurfaceStep_rad);
  }
  return truth;
}

}  // namespace cas::hils
