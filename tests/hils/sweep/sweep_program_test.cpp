// SPDX-License-Identifier: BSD-3-Clause
// Sweeps as a user flies them: whole, killed, in chunks, under a job array.
#include <gmock/gmock.h>
#include <signal.h>
#include <sqlite3.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

#include "hils/sweep/run_table.hpp"
#include "tests/support/child_process.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/scenario_text.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/support/wait_until.hpp"

namespace cas::test {
namespace {

using testing::HasSubstr;
using testing::Not;

namespace fs = std::filesystem;

/// For many flights, which take as long as the machine lets them.
constexpr base::Duration kSweepPatience = std::chrono::minutes(5);

const std::string kScenario = scenario_text(
    paper_quadrotor(),
    "[arm, takeoff: {altitude_m: 1}, hold: {duration_s: 1, measure: true}, land, disarm]");

constexpr const char* kStudy = R"(
schema: 1
name: hops
scenario: hop.yaml
sampling: latin_hypercube
points: 6
seeds: [1, 2]
vary:
  - {name: loss, key: line.packet_loss, uniform: [0, 0.05]}
  - {name: sensors, key: sensors, values: [table1, rtk]}
limits:
  - {share: judged, at_least: 0.5}
)";
constexpr std::size_t kRows = 24;

class Sweep : public testing::Test {
 protected:
  Sweep() {
    folder_.write("hop.yaml", kScenario);
    study_ = folder_.write("hops.yaml", kStudy);
  }

  static std::vector<std::string> hils(const std::vector<std::string>& arguments) {
    std::vector<std::string> command{binary_dir() + "/bin/hils", "sweep"};
    command.insert(command.end(), arguments.begin(), arguments.end());
    return command;
  }
  /// Runs `hils sweep ...` to its end. @return its output
  static std::string sweep(const std::vector<std::string>& arguments, int code = 0) {
    ChildProcess program(hils(arguments));
    EXPECT_EQ(program.wait_exit(kSweepPatience), code) << program.output();
    return program.output();
  }
  fs::path plan(const std::string& name, const fs::path& study) const {
    sweep({"plan", study.string(), "--out", folder_ / name});
    return folder_ / name;
  }
  static std::vector<std::string> lines_of(const std::string& text) {
    std::vector<std::string> lines;
    std::istringstream stream(text);
    for (std::string line; std::getline(stream, line);) lines.push_back(line);
    return lines;
  }
  static std::size_t journal_lines(const fs::path& sweep_folder) {
    const std::string text = TemporaryFolder::read(sweep_folder / "journal/chunk_1_of_1.jsonl");
    return static_cast<std::size_t>(std::ranges::count(text, '\n'));
  }
  /// A column of a table of results, by row.
  static std::vector<std::string> column(const std::string& csv, const std::string& name) {
    std::vector<std::string> cells;
    std::size_t index = 0;
    for (const std::string& line : lines_of(csv)) {
      const std::vector<std::string> fields = hils::csv_fields(line);
      if (cells.empty()) {
        index = static_cast<std::size_t>(std::ranges::find(fields, name) - fields.begin());
      }
      if (index >= fields.size()) return {};
      cells.push_back(fields[index]);
    }
    if (!cells.empty()) cells.erase(cells.begin());
    return cells;
  }
  /// A process that this one has started.
  static pid_t child_of(pid_t parent) {
    const std::string pid = std::to_string(parent);
    std::ifstream children("/proc/" + pid + "/task/" + pid + "/children");
    pid_t child = 0;
    children >> child;
    return child;
  }
  static bool is_stopped(pid_t process) {
    const std::string stat = TemporaryFolder::read("/proc/" + std::to_string(process) + "/stat");
    return stat.find(") T ") != std::string::npos;
  }

  TemporaryFolder folder_;
  fs::path study_;
};

/// Compared with the study, flown whole.
class WholeSweep : public Sweep {
 protected:
  /// The table of the study, flown whole; once for all tests.
  static const std::string& whole() {
    static const std::string table = [] {
      const TemporaryFolder folder;
      folder.write("hop.yaml", kScenario);
      const fs::path study = folder.write("hops.yaml", kStudy);
      sweep({"plan", study.string(), "--out", folder / "whole"});
      sweep({"run", folder / "whole", "--jobs", "2"});
      return TemporaryFolder::read(folder / "whole/chunks/chunk_1_of_1.csv");
    }();
    return table;
  }
};

TEST_F(WholeSweep, GivesARowForEachRun) {
  EXPECT_EQ(lines_of(whole()).size(), kRows + 1);
  for (const std::string& up : column(whole(), "up")) EXPECT_EQ(up, "1");
  for (const std::string& cell : column(whole(), "outcome")) EXPECT_EQ(cell, "passed");
}

/// kill -9 in the middle of runs, five times: no run is flown twice, and the table is the same to
/// the byte.
TEST_F(WholeSweep, KilledFiveTimesEndsWithTheSameTable) {
  const fs::path killed = plan("killed", study_);
  for (int kill = 0; kill < 5; ++kill) {
    const std::size_t before = journal_lines(killed);
    ChildProcess program(hils({"run", killed.string(), "--jobs", "2"}));
    EXPECT_TRUE(wait_until([&] { return journal_lines(killed) > before; }, kSweepPatience))
        << program.output();
    program.signal(SIGKILL);
    EXPECT_EQ(program.wait_exit(), 128 + SIGKILL) << program.output();
    EXPECT_LT(journal_lines(killed), kRows);  // it was killed in the middle
  }
  sweep({"run", killed.string(), "--jobs", "2"});
  EXPECT_EQ(TemporaryFolder::read(killed / "chunks/chunk_1_of_1.csv"), whole());
  EXPECT_EQ(journal_lines(killed), kRows);
  EXPECT_FALSE(fs::exists(killed / "work"));
}

TEST_F(Sweep, InterruptedSaysHowFarItIsAndGoesOn) {
  const fs::path stopped = plan("stopped", study_);
  ChildProcess program(hils({"run", stopped.string(), "--jobs", "1"}));
  ASSERT_TRUE(wait_until([&] { return journal_lines(stopped) > 0; }, kSweepPatience));
  program.signal(SIGINT);
  EXPECT_EQ(program.wait_exit(), 130);
  EXPECT_THAT(program.output(), HasSubstr("'hils sweep run' goes on"));
  EXPECT_THAT(sweep({"status", stopped.string()}), HasSubstr("of 24 runs flown"));
  sweep({"collect", stopped.string(), "--again", "0"}, 3);  // runs are missing
}

TEST_F(Sweep, CollectedBeforeAnyRunSaysThatNothingWasFlown) {
  const fs::path planned = plan("planned", study_);
  const std::string said = sweep({"collect", planned.string()}, 3);
  EXPECT_THAT(said, HasSubstr("Nothing was flown: hops, 24 runs; 'hils sweep run " +
                              planned.string() + "' flies them"));
  EXPECT_THAT(said, Not(HasSubstr("MISSED")));
  EXPECT_THAT(TemporaryFolder::read(planned / "sweep.html"), HasSubstr("Nothing was flown"));
}

TEST_F(Sweep, AFlightThatDoesNotReachItsMeasuredStepHasNoMargin) {
  std::string weak = kScenario;
  weak.replace(weak.find("altitude_m: 1}"), 14, "altitude_m: 1, timeout_s: 0.5}");
  folder_.write("weak.yaml", weak + "limits: {rms: {x_m: 1}, delivered_pct: 1}\n");
  const fs::path study =
      folder_.write("weak_study.yaml",
                    "schema: 1\nname: weak\nscenario: weak.yaml\nseeds: [1]\nvary:\n"
                    "  - {name: loss, key: line.packet_loss, values: [0]}\n");
  const fs::path flown = plan("weak", study);
  sweep({"run", flown.string()});
  const std::string table = TemporaryFolder::read(flown / "chunks/chunk_1_of_1.csv");
  EXPECT_EQ(column(table, "up"), std::vector<std::string>{"0"}) << table;
  EXPECT_EQ(column(table, "least_margin_pct"), std::vector<std::string>{""}) << table;
}

TEST_F(Sweep, WarningsOfItsFlightsAreInItsResults) {
  folder_.write(
      "w.sdf",
      "<sdf version='1.6'>\n<world name='w'>\n<model name='m'><static>1</static>\n"
      "<link name='l'><colision name='c'/><collision name='d'><geometry><plane/></geometry>"
      "</collision></link></model>\n</world></sdf>");
  folder_.write("there.yaml", kScenario + "world: w.sdf\n");
  const fs::path study =
      folder_.write("there_study.yaml",
                    "schema: 1\nname: there\nscenario: there.yaml\nvary:\n"
                    "  - {name: loss, key: line.packet_loss, values: [0, 0.01]}\n");
  const std::string warning = "warning in 2 of 2 flights: " + (folder_ / "w.sdf").string() + ":4: ";
  const std::string said =
      sweep({study.string(), "--out", folder_ / "there", "--again", "0", "--jobs", "2"});
  EXPECT_THAT(said, HasSubstr(warning));
  for (const char* file : {"sweep.html", "junit.xml"}) {
    EXPECT_THAT(TemporaryFolder::read(folder_ / "there" / file), HasSubstr(warning)) << file;
  }
}

TEST_F(WholeSweep, ThreeChunksAreTheWholeToTheByte) {
  const fs::path cut = plan("cut", study_);
  std::string together;
  for (const std::string k : {"3", "1", "2"}) {
    sweep({"run", cut.string(), "--chunk", k + "/3", "--jobs", "2"});
  }
  for (const std::string k : {"1", "2", "3"}) {
    const std::string chunk = TemporaryFolder::read(cut / ("chunks/chunk_" + k + "_of_3.csv"));
    together += together.empty() ? chunk : chunk.substr(chunk.find('\n') + 1);
  }
  EXPECT_EQ(together, whole());
  EXPECT_EQ(sweep({"run", cut.string()}).find("0 of them flown now") != std::string::npos, true);
}

/// The process of a run is killed under the runner: its row says so, and can be flown once more.
TEST_F(WholeSweep, ARunThatDiesCostsItsOwnRow) {
  const fs::path hurt = plan("hurt", study_);
  ChildProcess program(hils({"run", hurt.string(), "--jobs", "1"}));
  pid_t child = 0;
  // One that has been stopped cannot end by itself before it is killed.
  ASSERT_TRUE(wait_until(
      [&] {
        child = child_of(program.pid());
        return child > 0 && ::kill(child, SIGSTOP) == 0 && is_stopped(child);
      },
      kSweepPatience));
  ASSERT_EQ(::kill(child, SIGKILL), 0);
  EXPECT_EQ(program.wait_exit(kSweepPatience), 0) << program.output();
  const std::string table = TemporaryFolder::read(hurt / "chunks/chunk_1_of_1.csv");
  const std::vector<std::string> outcomes = column(table, "outcome");
  EXPECT_EQ(std::ranges::count(outcomes, "died"), 1) << table;
  EXPECT_EQ(std::ranges::count(outcomes, "passed"), static_cast<long>(kRows) - 1);
  EXPECT_THAT(table, HasSubstr("was ended by signal 9 (Killed)"));
  sweep({"run", hurt.string(), "--retry"});
  EXPECT_EQ(TemporaryFolder::read(hurt / "chunks/chunk_1_of_1.csv"), whole());

  // As if it had died in another chunk, whose journal is read later: the flown result counts.
  std::istringstream lines(TemporaryFolder::read(hurt / "journal/chunk_1_of_1.jsonl"));
  std::ofstream later(hurt / "journal/chunk_2_of_2.jsonl");
  for (std::string line; std::getline(lines, line);) {
    if (line.find("\"died\"") != std::string::npos) later << line << '\n';
  }
  later.close();
  EXPECT_GT(fs::file_size(hurt / "journal/chunk_2_of_2.jsonl"), 0U);
  EXPECT_THAT(sweep({"status", hurt.string()}), Not(HasSubstr("died")));
}

TEST_F(Sweep, ARunThatHangsCostsItsOwnRow) {
  const fs::path study = folder_.write("slow.yaml",
                                       "schema: 1\nname: slow\nscenario: hop.yaml\n"
                                       "deadline_s: 10\nvary:\n"
                                       "  - {name: hold_s, key: 'steps[hold].duration_s', values: "
                                       "[1, 86400, 2]}\n");
  const fs::path slow = plan("slow", study);
  EXPECT_THAT(sweep({"run", slow.string(), "--jobs", "1"}), HasSubstr("no result after 10 s"));
  EXPECT_EQ(column(TemporaryFolder::read(slow / "chunks/chunk_1_of_1.csv"), "outcome"),
            (std::vector<std::string>{"passed", "hung", "passed"}));
}

TEST_F(Sweep, WhatNoRunTakesEndsWithTwoAndTheKey) {
  const fs::path study = folder_.write("wrong.yaml",
                                       "schema: 1\nname: wrong\nscenario: hop.yaml\nvary:\n"
                                       "  - {key: line.packet_los, values: [0.1, 0.2]}\n");
  EXPECT_THAT(sweep({"plan", study.string(), "--out", folder_ / "wrong"}, 2),
              HasSubstr("row 1: scenario.yaml:"));
  // Keys of a further plugin are read in flight.
  const fs::path later =
      folder_.write("later.yaml",
                    "schema: 1\nname: later\nscenario: hop.yaml\nvary:\n"
                    "  - {key: plugins, values: ['[{plugin: wind, gost: 1}]']}\n");
  const std::string said = sweep({"run", plan("later", later).string()}, 2);
  EXPECT_THAT(said, HasSubstr("scenario.yaml:"));
  EXPECT_THAT(said, HasSubstr("plugins[0].gost: unknown key"));
}

TEST_F(Sweep, ARowWithOtherFiguresThanItsTableIsRefused) {
  const fs::path study = folder_.write(
      "named.yaml",
      "schema: 1\nname: named\nscenario: hop.yaml\nset:\n"
      "  'steps[2]': {trajectory: {name: jump, shape: step, size_m: 1, duration_s: 4, measure: "
      "true}}\nvary:\n"
      "  - {name: word, key: 'steps[2].trajectory.name', values: [jump, leap]}\n");
  const fs::path named = plan("named", study);
  sweep({"run", named.string(), "--jobs", "2"});
  const std::string table = TemporaryFolder::read(named / "chunks/chunk_1_of_1.csv");
  EXPECT_EQ(column(table, "outcome")[1], "refused") << table;
  EXPECT_THAT(table, HasSubstr("the run has other figures than the columns of its table"));
}

TEST_F(WholeSweep, ShowPrintsACommandThatGivesTheSameBytes) {
  const fs::path one = plan("one", study_);
  sweep({"run", one.string(), "--chunk", "5/24"});
  const std::vector<std::string> shown = lines_of(sweep({"show", one.string(), "5"}));
  const auto after = [&shown](const std::string& beginning) {
    const auto at = std::ranges::find_if(
        shown, [&](const std::string& line) { return line.starts_with(beginning); });
    return at == shown.end() ? std::string() : *(at + 1);
  };
  ChildProcess again({"/bin/sh", "-c", after("Again")});
  again.wait_exit(kSweepPatience);
  ASSERT_TRUE(fs::exists(one / "again/row_5/report.html")) << again.output();
  const auto line = std::ranges::find_if(
      shown, [](const std::string& text) { return text.starts_with("The same bytes: "); });
  ASSERT_NE(line, shown.end());
  ChildProcess digest({"/bin/sh", "-c", line->substr(std::string("The same bytes: ").size())});
  EXPECT_EQ(digest.wait_exit(), 0);
  const std::string expected = column(whole(), "truth_sha256")[4];
  EXPECT_EQ(digest.output().substr(0, 64), expected);
  EXPECT_THAT(after("The same bytes"), HasSubstr(expected));
}

/// Counts of a query of one number.
int number_in(const fs::path& database, const std::string& sql) {
  sqlite3* handle = nullptr;
  int number = -1;
  if (sqlite3_open_v2(database.c_str(), &handle, SQLITE_OPEN_READONLY, nullptr) == SQLITE_OK) {
    const auto read = [](void* result, int, char** cells, char**) {
      *static_cast<int*>(result) = std::atoi(cells[0]);
      return 0;
    };
    sqlite3_exec(handle, sql.c_str(), read, &number, nullptr);
  }
  sqlite3_close(handle);
  return number;
}

/// A job array whose sbatch keeps the script; its tasks are then flown on this machine. Submitted
/// again with another length of a chunk, it is cut as before.
TEST_F(WholeSweep, AJobArrayGivesTheSameTable) {
  const fs::path array = plan("array", study_);
  sweep({"run", array.string(), "--chunk", "2/3"});  // is not submitted again
  const fs::path sbatch = folder_.write("bin/sbatch",
                                        "#!/bin/sh\n"
                                        "grep -q '^#SBATCH --array=1,3$' \"$1\" || exit 1\n"
                                        "grep -q '^#SBATCH --partition=lab$' \"$1\" || exit 1\n"
                                        "echo Submitted batch job 42\n");
  fs::permissions(sbatch, fs::perms::owner_all);
  const auto submit = [&](const std::string& path, const std::string& flag,
                          const std::string& value) {
    std::vector<std::string> command{"/usr/bin/env", "PATH=" + path};
    const auto own =
        hils({"run", array.string(), "--slurm", flag, value, "--partition", "lab", "--jobs", "2"});
    command.insert(command.end(), own.begin(), own.end());
    return command;
  };
  // An array that Slurm refuses fixes no chunks for a later one.
  const fs::path refusing =
      folder_.write("refusing/sbatch", "#!/bin/sh\necho No account; exit 1\n");
  fs::permissions(refusing, fs::perms::owner_all);
  ChildProcess refused(submit((folder_ / "refusing").string() + ":/usr/bin:/bin", "--chunks", "5"));
  EXPECT_EQ(refused.wait_exit(kSweepPatience), 3);
  EXPECT_THAT(refused.output(), HasSubstr("No account"));
  ChildProcess nowhere(submit(folder_ / "nothing", "--chunks", "3"));
  EXPECT_EQ(nowhere.wait_exit(kSweepPatience), 3);
  EXPECT_THAT(nowhere.output(),
              HasSubstr("there is no sbatch on this machine; sweep.sbatch was written "
                        "for 3 chunks"));
  const std::string path = (folder_ / "bin").string() + ":/usr/bin:/bin";
  ChildProcess other(submit(path, "--chunks", "4"));
  EXPECT_EQ(other.wait_exit(kSweepPatience), 2);
  EXPECT_THAT(other.output(), HasSubstr("was written for 3 chunks"));
  ChildProcess program(submit(path, "--chunk-minutes", "1000"));
  EXPECT_EQ(program.wait_exit(kSweepPatience), 0) << program.output();
  EXPECT_THAT(program.output(), HasSubstr("Submitted batch job 42"));
  for (const std::string task : {"1", "3"}) {
    ChildProcess job({"/usr/bin/env", "SLURM_ARRAY_TASK_ID=" + task,
                      "TMPDIR=" + (folder_ / "tmp").string(), "/bin/sh",
                      (array / "slurm/sweep.sbatch").string()});
    EXPECT_EQ(job.wait_exit(kSweepPatience), 0) << job.output();
  }
  EXPECT_TRUE(fs::is_empty(folder_ / "tmp"));

  EXPECT_THAT(sweep({"collect", array.string(), "--again", "1"}),
              HasSubstr("24 of 24 runs flown, 24 with a verdict"));
  EXPECT_EQ(TemporaryFolder::read(array / "results.csv"), whole());
  EXPECT_EQ(lines_of(TemporaryFolder::read(array / "machine.csv")).size(), kRows + 1);
  EXPECT_EQ(number_in(array / "sweep.sqlite", "SELECT count(*) FROM runs WHERE up = 1"), 24);
  EXPECT_EQ(number_in(array / "sweep.sqlite",
                      "SELECT count(*) FROM runs JOIN machine USING (row) WHERE loss < 0.05"),
            24);
  const std::string page = TemporaryFolder::read(array / "sweep.html");
  for (const char* part : {"Success maps", "Sensitivity", "Worst runs", "/report.html\""}) {
    EXPECT_THAT(page, HasSubstr(part)) << part;
  }
  EXPECT_THAT(TemporaryFolder::read(array / "junit.xml"),
              HasSubstr("tests=\"2\" failures=\"0\" errors=\"0\""));
}

TEST_F(Sweep, AgainstAnotherOneSaysWhatBecameWorse) {
  const auto study_with = [this](const std::string& name, const std::string& climb) {
    return folder_.write(
        name + ".yaml",
        "schema: 1\nname: " + name +
            "\nscenario: hop.yaml\nset: {line.extra_delay_us: 5000, 'steps[takeoff].timeout_s': " +
            climb +
            "}\nseeds: {first: 1, count: 3}\nvary:\n"
            "  - {name: sensors, key: sensors, values: [table1, rtk]}\n");
  };
  const fs::path good = folder_ / "good";
  const fs::path bad = folder_ / "bad";
  sweep({study_with("good", "30").string(), "--out", good.string(), "--again", "0"});
  sweep({study_with("bad", "1").string(), "--out", bad.string(), "--again", "0"});
  const std::string said =
      sweep({"collect", bad.string(), "--again", "0", "--against", good.string()});
  // 6 of 6 against 0 of 6: 2 / 924 by Fisher's test.
  EXPECT_TRUE(std::regex_search(
      said, std::regex("all: stays up +6 of 6, 100.00 % .* 0 of 6, 0.00 % .* 0.0022 +WORSE\n")))
      << said;
  EXPECT_THAT(TemporaryFolder::read(bad / "sweep.html"),
              HasSubstr("6 rows stayed up before and do not now: 1, 2, 3, 4, 5, 6"));
}

}  // namespace
}  // namespace cas::test
