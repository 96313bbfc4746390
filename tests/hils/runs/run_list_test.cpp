// SPDX-License-Identifier: BSD-3-Clause
#include "hils/runs/run_list.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <string>

#include "hils/runs/runs_page.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/temporary_folder.hpp"

namespace {

namespace fs = std::filesystem;
using namespace cas::hils;

std::string summary(const std::string& scenario, bool passed, double rms_m) {
  return R"({"schema": 2, "scenario": ")" + scenario +
         R"(", "architecture": "tcas", "seed": 3, "valid": true, "passed": )" +
         (passed ? "true" : "false") + R"(, "failures": [)" + (passed ? "" : "\"it hit <b>\"") +
         R"(], "virtual_clock": true, "wall_s": 1.5, "vehicles": [{"name": "iris0", "rms": {"x_m": 0.1}, "rms_position_m": )" +
         std::to_string(rms_m) + R"(, "peak_error_m": null, "stages": [{"begin_s": 1}]}]})";
}

class Runs : public testing::Test {
 protected:
  Runs() {
    write("old", summary("hover", true, 0.1), std::chrono::hours(-2));
    write("deep/new run", summary("wall", false, 0.5), std::chrono::hours(-1));
    folder_.write("old/report.html", "");
    folder_.write("deep/new run/report.html", "");
    folder_.write("old/run/hilsim.yaml",
                  "seed: 3\nvehicles: [{name: iris0, plugins: [{plugin: wind, mean_m_s: 8}]}]\n");
    folder_.write("broken/summary.json", "{");
  }
  void write(const std::string& name, const std::string& text, fs::file_time_type::duration age) {
    fs::last_write_time(folder_.write(name + "/summary.json", text),
                        fs::file_time_type::clock::now() + age);
  }

  cas::test::TemporaryFolder folder_;
};

TEST_F(Runs, AreListedWithTheirFiguresTheLatestFirst) {
  const RunList list = find_runs(folder_.path());
  ASSERT_EQ(list.runs.size(), 2U);
  EXPECT_EQ(list.runs[0].folder, "deep/new run");
  EXPECT_EQ(list.runs[0].verdict, "FAILED");
  EXPECT_EQ(list.runs[0].why, "it hit <b>");
  EXPECT_EQ(list.runs[1].figure("rms_position_m"), 0.1);
  EXPECT_EQ(list.runs[1].figure("rms.x_m"), 0.1);
  EXPECT_EQ(list.runs[1].figure("peak_error_m"), std::nullopt);
  EXPECT_EQ(list.runs[1].settings.at("hilsim.vehicles[iris0].plugins[wind].mean_m_s"), "8");
  ASSERT_EQ(list.unread.size(), 1U);
  EXPECT_NE(list.unread[0].find("broken/summary.json: is not JSON"), std::string::npos);
  EXPECT_NE(run_table(list.runs).find("FAILED   wall"), std::string::npos) << run_table(list.runs);
}

TEST_F(Runs, PageLinksToReportsAndNoTextOfARunIsMarkup) {
  const std::string page = runs_page(folder_.path(), find_runs(folder_.path()));
  EXPECT_NE(page.find("<a href=\"deep/new%20run/report.html\">"), std::string::npos);
  EXPECT_EQ(page.find("it hit <b>"), std::string::npos);
  EXPECT_NE(page.find("it hit &lt;b&gt;"), std::string::npos);
}

TEST(RunList, RefusesAFolderThatIsNotThere) {
  EXPECT_EQ(cas::test::refusal([] { find_runs("/nowhere/at/all"); }),
            "/nowhere/at/all: no such folder");
}

}  // namespace
