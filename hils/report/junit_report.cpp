// SPDX-License-Identifier: BSD-3-Clause
#include "hils/report/junit_report.hpp"

#include <fmt/format.h>

#include <cstddef>

#include "hils/report/plot.hpp"

namespace cas::hils {

namespace {

/// @param who  behind the name of the suite: ".left", or nothing
std::string junit_suite(const Measurement& figures, const Verdict& verdict,
                        const std::string& who) {
  const std::string suite = escape_xml(
      fmt::format("hils.{}.{}{}", figures.scenario, to_string(figures.architecture), who));
  std::string cases;
  std::size_t failed = 0;
  std::size_t errors = 0;
  if (verdict.passed) {
    cases += fmt::format("  <testcase classname=\"{}\" name=\"limits\" time=\"{:.3f}\"/>\n", suite,
                         figures.wall_s);
  }
  for (std::size_t i = 0; i < verdict.failures.size(); ++i) {
    const std::string sentence = escape_xml(verdict.failures[i]);
    cases +=
        fmt::format("  <testcase classname=\"{}\" name=\"{} {}\" time=\"{:.3f}\">", suite,
                    verdict.valid ? "limit" : "validity", i + 1, i == 0 ? figures.wall_s : 0.0);
    cases += fmt::format("<{} message=\"{}\"/></testcase>\n", verdict.valid ? "failure" : "error",
                         sentence);
    ++(verdict.valid ? failed : errors);
  }
  return fmt::format(
      "<testsuite name=\"{}\" tests=\"{}\" failures=\"{}\" errors=\"{}\" skipped=\"0\" "
      "time=\"{:.3f}\">\n{}</testsuite>\n",
      suite, failed + errors + (verdict.passed ? 1 : 0), failed, errors, figures.wall_s, cases);
}

}  // namespace

std::string junit_report(const RunResult& run) {
  std::string text = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n";
  if (!run.has_several()) return text + junit_suite(run.vehicles.front().figures, run.verdict, "");
  text += "<testsuites>\n";
  for (const VehicleResult& vehicle : run.vehicles) {
    text += junit_suite(vehicle.figures, vehicle.verdict, "." + vehicle.figures.vehicle);
  }
  return text + "</testsuites>\n";
}

}  // namespace cas::hils
