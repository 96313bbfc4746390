// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "hils/compare/comparison.hpp"
#include "hils/report/document.hpp"

namespace cas::hils {

/// The comparison in one line: scenario, seeds, times, clock.
std::string comparison_headline(const ComparisonPlan& plan);
/// How much the runs of a variant are worth: "30 of 30 runs valid, 30 flown to the end", and why
/// others are not.
std::string validity_words(const VariantResult& result);

/// Each table with the rows of [HILS] below ours where it has any.
Document comparison_report(const ComparisonPlan& plan, const std::vector<VariantResult>& results);
/// comparison.json. On the virtual clock it is the same to the byte for the same plan.
std::string comparison_json(const ComparisonPlan& plan, const std::vector<VariantResult>& results);
/// [HILS] Fig. 16 (received rates over time) and Fig. 17 (position and heading), first seed.
std::vector<std::pair<std::string, Plot>> comparison_plots(
    const std::vector<VariantResult>& results);

}  // namespace cas::hils
