// SPDX-License-Identifier: BSD-3-Clause
#include "hils/report/junit.hpp"

#include <fmt/format.h>

#include "hils/report/plot.hpp"

namespace cas::hils {

JunitSuite::JunitSuite(const std::string& name) : name_(escape_xml(name)) {}

void JunitSuite::add(const std::string& name, Outcome outcome, const std::string& message,
                     std::optional<double> time_s, const std::string& group) {
  ++tests_;
  cases_ += fmt::format("  <testcase classname=\"{}{}{}\" name=\"{}\" time=\"{}\"", name_,
                        group.empty() ? "" : ".", escape_xml(group), escape_xml(name),
                        time_s ? fmt::format("{:.3f}", *time_s) : "0");
  if (outcome == Outcome::kPassed) {
    cases_ += "/>\n";
    return;
  }
  const bool failed = outcome == Outcome::kFailed;
  const bool skipped = outcome == Outcome::kSkipped;
  ++(failed ? failures_ : skipped ? skipped_ : errors_);
  const std::string why = skipped && message.empty()
                              ? std::string()
                              : fmt::format(" message=\"{}\"", escape_xml(message));
  cases_ += fmt::format("><{}{}/></testcase>\n",
                        failed    ? "failure"
                        : skipped ? "skipped"
                                  : "error",
                        why);
}

void JunitSuite::say(const std::string& line) { output_ += escape_xml(line) + "\n"; }

std::string JunitSuite::element(std::optional<double> time_s) const {
  return fmt::format(
      "<testsuite name=\"{}\" tests=\"{}\" failures=\"{}\" errors=\"{}\" skipped=\"{}\"{}>\n"
      "{}{}</testsuite>\n",
      name_, tests_, failures_, errors_, skipped_,
      time_s ? fmt::format(" time=\"{:.3f}\"", *time_s) : "", cases_,
      output_.empty() ? "" : fmt::format("  <system-out>{}</system-out>\n", output_));
}

std::string JunitSuite::report(std::optional<double> time_s) const {
  return kXmlHead + element(time_s);
}

}  // namespace cas::hils
