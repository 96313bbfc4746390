// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "hils/report/document.hpp"
#include "hils/sweep/share_limits.hpp"
#include "hils/sweep/sweep_view.hpp"

namespace cas::hils {

/// Further contents of a page on a sweep.
struct SweepPage {
  std::vector<std::pair<std::string, std::string>> maps{};  ///< parameters of maps asked for
  const SweepView* before = nullptr;       ///< the sweep that this one is compared with
  std::vector<std::size_t> worst{};        ///< rows, the worst first
  std::vector<std::size_t> flown_again{};  ///< of those: their reports lie in again/
};

/// Verdict, limits, outcomes, comparison; on a page also success maps, shares along each parameter,
/// distributions, sensitivity, worst runs.
/// @throws base::ConfigError when a map asks for a parameter that is not there
Document sweep_report(const SweepView& view, const std::vector<ShareCheck>& checks,
                      const SweepPage& page);

}  // namespace cas::hils
