// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/flight/status_texts.hpp"

namespace cas::fcu {

void StatusTexts::add(Severity severity, std::string text) {
  if (lines_.size() < kMostLines) lines_.push_back({severity, std::move(text)});
}

}  // namespace cas::fcu
