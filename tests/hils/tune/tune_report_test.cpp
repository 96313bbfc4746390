// SPDX-License-Identifier: BSD-3-Clause
#include "hils/tune/tune_report.hpp"

#include <gtest/gtest.h>

#include <string>

namespace cas::hils {
namespace {

TEST(TuneReport, HasTheWarningsOfAllFlights) {
  TuneResult result;
  result.candidates.resize(1);
  result.warnings.add({"link 'arm': taken as a point mass"});
  result.warnings.add({});
  const Document report = tune_report(TuneStudy{}, result, {});
  const std::string sentence = "warning in 1 of 2 flights: link 'arm': taken as a point mass";
  EXPECT_NE(write_text(report).find(sentence), std::string::npos) << write_text(report);
  EXPECT_NE(write_html(report).find("warning in 1 of 2 flights"), std::string::npos);
}

}  // namespace
}  // namespace cas::hils
