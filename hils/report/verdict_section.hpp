// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "hils/measure/judgement.hpp"
#include "hils/report/document.hpp"

namespace cas::hils {

/// The verdict on top of a report, with failures, remarks and warnings.
/// @param line  behind the word: the flight
Document::Verdict verdict_block(const Verdict& verdict, const std::string& line);

/// Limits of a run: name, value, bound, margin and whether it was kept. The margin is how far the
/// value is from the bound, negative beyond it, with its share of the bound. Those that decide come
/// first.
Document::Table limit_table(const std::string& caption, const Verdict& verdict);

}  // namespace cas::hils
