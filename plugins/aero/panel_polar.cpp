// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/aero/panel_polar.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/angles.hpp"
#include "plugins/common/number_csv.hpp"

namespace cas::sim {
namespace {

constexpr std::size_t kMostBytes = 4U << 20U;
constexpr double kMostCoefficient = 100;

PanelCoefficients between(const PanelCoefficients& a, const PanelCoefficients& b, double share) {
  return {.lift = std::lerp(a.lift, b.lift, share),
          .drag = std::lerp(a.drag, b.drag, share),
          .moment = std::lerp(a.moment, b.moment, share)};
}

/// Why a row cannot be; nullptr: it can.
const char* fault_of(const std::array<double, 5>& row) {
  const auto& [reynolds, alpha_deg, lift, drag, moment] = row;
  if (!(reynolds > 0)) return "reynolds must be above 0";
  if (!(std::abs(alpha_deg) <= 180)) return "alpha_deg must lie in [-180, 180]";
  if (!(drag >= 0)) return "CD must not be below 0";
  const double most = std::max({std::abs(lift), drag, std::abs(moment)});
  return most <= kMostCoefficient ? nullptr : "a coefficient is beyond 100";
}

}  // namespace

PanelPolar::PanelPolar(const std::filesystem::path& file, double plate_normal_force)
    : plate_normal_force_(plate_normal_force) {
  NumberCsv csv(file, "polar", kMostBytes, "reynolds,alpha_deg,CL,CD,Cm");
  const auto check_whole = [&] {
    if (!blocks_.empty() && blocks_.back().rows.size() < 2) {
      csv.fail("a Reynolds number needs two angles at least");
    }
  };
  for (std::array<double, 5> row{}; csv.next(row);) {
    if (const char* fault = fault_of(row)) csv.fail(fault);
    const double alpha_rad = base::radians(row[1]);
    if (blocks_.empty() || row[0] > blocks_.back().reynolds) {
      check_whole();
      blocks_.push_back({.reynolds = row[0], .least_drag = row[3], .rows = {}});
    } else if (row[0] < blocks_.back().reynolds) {
      csv.fail("reynolds must not fall from line to line");
    } else if (alpha_rad <= blocks_.back().rows.back().alpha_rad) {
      csv.fail("alpha_deg must rise from line to line of one Reynolds number");
    }
    Block& block = blocks_.back();
    block.least_drag = std::min(block.least_drag, row[3]);
    block.rows.push_back({alpha_rad, {.lift = row[2], .drag = row[3], .moment = row[4]}});
  }
  check_whole();
  if (blocks_.empty()) csv.fail("needs two angles at least");
}

PanelCoefficients PanelPolar::at(double alpha_rad, double reynolds) const {
  const auto above = std::ranges::upper_bound(blocks_, reynolds, {}, &Block::reynolds);
  if (above == blocks_.begin()) return of_block(blocks_.front(), alpha_rad);
  const Block& below = *(above - 1);
  if (above == blocks_.end()) return of_block(below, alpha_rad);
  const double share = (reynolds - below.reynolds) / (above->reynolds - below.reynolds);
  return between(of_block(below, alpha_rad), of_block(*above, alpha_rad), share);
}

PanelCoefficients PanelPolar::of_block(const Block& block, double alpha_rad) const {
  const auto above = std::ranges::upper_bound(block.rows, alpha_rad, {}, &Row::alpha_rad);
  if (above != block.rows.begin() && above != block.rows.end()) {
    const Row& below = *(above - 1);
    const double share = (alpha_rad - below.alpha_rad) / (above->alpha_rad - below.alpha_rad);
    return between(below.coefficients, above->coefficients, share);
  }
  const Row& end = above == block.rows.begin() ? block.rows.front() : block.rows.back();
  const double normal = plate_normal_force_ * std::sin(alpha_rad);
  const PanelCoefficients plate{.lift = normal * std::cos(alpha_rad),
                                .drag = block.least_drag + normal * std::sin(alpha_rad),
                                .moment = 0};
  const double kFade_rad = base::radians(10);
  const double beyond = std::abs(alpha_rad - end.alpha_rad);
  return between(end.coefficients, plate, std::min(beyond / kFade_rad, 1.0));
}

}  // namespace cas::sim
