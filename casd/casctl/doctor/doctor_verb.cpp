// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <iostream>
#include <memory>

#include "casd/casctl/doctor/doctor.hpp"
#include "casd/casctl/verbs/verbs.hpp"

namespace cas::casctl {
namespace {

using nlohmann::json;

const char* word(Health health) {
  switch (health) {
    case Health::kGood:
      return "good";
    case Health::kWarning:
      return "warning";
    case Health::kBad:
      return "bad";
  }
  return "?";
}

const char* mark(Health health) {
  switch (health) {
    case Health::kGood:
      return "  ok   ";
    case Health::kWarning:
      return "  warn ";
    case Health::kBad:
      return "  BAD  ";
  }
  return "?";
}

int examine(Session& session, double seconds) {
  const std::vector<Finding> findings = diagnose(gather_facts(session, seconds));
  const bool ill = std::any_of(findings.begin(), findings.end(),
                               [](const Finding& f) { return f.health == Health::kBad; });
  json all = json::array();
  std::string text;
  for (const Finding& finding : findings) {
    all.push_back(
        {{"health", word(finding.health)}, {"what", finding.what}, {"remedy", finding.remedy}});
    text += mark(finding.health) + finding.what + "\n";
    if (!finding.remedy.empty()) text += "         -> " + finding.remedy + "\n";
  }
  text += ill ? "Not ready to fly: see the lines marked BAD." : "Ready to fly.";
  report(session.options(), {{"ready", !ill}, {"findings", all}}, text);
  return ill ? kRefused : kDone;
}

}  // namespace

void add_doctor_verb(CommandLine& line) {
  const auto seconds = std::make_shared<double>(2);
  line.add_verb("doctor", "Check the HIL set-up and say what is wrong, with the remedy",
                "casctl doctor", [seconds](Session& session) { return examine(session, *seconds); })
      ->add_option("--seconds", *seconds, "How long to watch")
      ->check(CLI::Range(0.1, 600.0))
      ->capture_default_str();
}

}  // namespace cas::casctl
