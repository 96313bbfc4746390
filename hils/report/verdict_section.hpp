// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "hils/measure/judgement.hpp"
#include "hils/report/html_page.hpp"

namespace cas::hils {

/// "Passed", "Failed" or "Not valid".
std::string title_of(const Verdict& verdict);

/// The verdict on top of a report, in its colour. @param line  below the word: the flight
void add_verdict(HtmlPage& page, const Verdict& verdict, const std::string& line);

/// A table of the run's limits; the deciding ones come first.
void add_limits(HtmlPage& page, const std::string& caption, const Verdict& verdict);

}  // namespace cas::hils
