// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
#include <string>

namespace cas::hils {

/// Collects the cases of a test suite and writes them as a JUnit report, for continuous
/// integration.
class JunitSuite {
 public:
  enum class Outcome {
    kPassed,
    kFailed,
    kError,  ///< there is no verdict
    kSkipped,
  };

  explicit JunitSuite(const std::string& name);

  /// @param message  why; a case that passed has none
  /// @param time_s  nullopt: of no interest
  /// @param group  names a part of the suite: "rotor_stopped"
  void add(const std::string& name, Outcome outcome, const std::string& message = "",
           std::optional<double> time_s = {}, const std::string& group = "");
  /// Adds a line to the suite's `system-out`.
  void say(const std::string& line);
  /// The element `testsuite`. @param time_s  of the whole suite
  std::string element(std::optional<double> time_s = {}) const;
  /// A whole report with this suite only.
  std::string report(std::optional<double> time_s = {}) const;

 private:
  std::string name_;
  std::string cases_;
  std::string output_;  // lines
  std::size_t tests_ = 0, failures_ = 0, errors_ = 0, skipped_ = 0;
};

/// First line of a report.
inline constexpr const char* kXmlHead = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n";

}  // namespace cas::hils
