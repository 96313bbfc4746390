// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "mavlink/common/enums.hpp"

namespace cas::fcu {

/// Texts that wait to be sent as STATUSTEXT. Commander and protocols add them; GroundProtocols
/// takes and sends them. Beyond 64 a text is dropped.
class StatusTexts {
 public:
  using Severity = mavlink::common::MavSeverity;
  struct Line {
    Severity severity = Severity::kInfo;
    std::string text;
  };

  void add(Severity severity, std::string text) {
    if (lines_.size() < kMostLines) lines_.push_back({severity, std::move(text)});
  }
  void info(std::string text) { add(Severity::kInfo, std::move(text)); }
  void warn(std::string text) { add(Severity::kWarning, std::move(text)); }
  void critical(std::string text) { add(Severity::kCritical, std::move(text)); }

  std::vector<Line> take() { return std::exchange(lines_, {}); }
  bool empty() const { return lines_.empty(); }

 private:
  static constexpr std::size_t kMostLines = 64;
  std::vector<Line> lines_;
};

}  // namespace cas::fcu
