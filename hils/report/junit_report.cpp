// SPDX-License-Identifier: BSD-3-Clause
#include "hils/report/junit_report.hpp"

#include <fmt/format.h>

#include "base/text.hpp"
#include "hils/report/junit.hpp"

namespace cas::hils {
namespace {

/// A case for the verdict and one for each limit and validity check, under the same names whatever
/// the result.
std::string junit_suite(const std::string& name, double wall_s, const Verdict& verdict) {
  using Outcome = JunitSuite::Outcome;
  JunitSuite suite(name);
  suite.add("verdict",
            verdict.passed  ? Outcome::kPassed
            : verdict.valid ? Outcome::kFailed
                            : Outcome::kError,
            base::joined(verdict.failures, "; "), wall_s);
  for (const LimitCheck& check : verdict.checks) {
    const bool decides_validity = check.kind == LimitCheck::Kind::kValidity;
    suite.add(check.what,
              !check.judged      ? Outcome::kSkipped
              : check.kept       ? Outcome::kPassed
              : decides_validity ? Outcome::kError
                                 : Outcome::kFailed,
              check.judged ? check.sentence : "", 0);
  }
  for (const std::string& warning : verdict.warnings) suite.say("warning: " + warning);
  return suite.element(wall_s);
}

/// @param who  appended to the name of the suite: ".left", or nothing
std::string junit_suite(const Measurement& figures, const Verdict& verdict,
                        const std::string& who) {
  return junit_suite(
      fmt::format("hils.{}.{}{}", figures.scenario, to_string(figures.architecture), who),
      figures.wall_s, verdict);
}

}  // namespace

std::string junit_report(const RunResult& run) {
  std::string text = kXmlHead;
  if (!run.has_several()) return text + junit_suite(run.vehicles.front().figures, run.verdict, "");
  text += "<testsuites>\n";
  for (const VehicleResult& vehicle : run.vehicles) {
    text += junit_suite(vehicle.figures, vehicle.verdict, "." + vehicle.figures.vehicle);
  }
  return text + "</testsuites>\n";
}

std::string junit_report(const std::string& name, double wall_s, const Verdict& verdict) {
  return kXmlHead + junit_suite(name, wall_s, verdict);
}

std::string junit_report(const std::vector<std::pair<std::string, Verdict>>& suites,
                         double wall_s) {
  std::string text = fmt::format("{}<testsuites>\n", kXmlHead);
  for (const auto& [name, verdict] : suites) text += junit_suite(name, wall_s, verdict);
  return text + "</testsuites>\n";
}

}  // namespace cas::hils
