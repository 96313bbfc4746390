// SPDX-License-Identifier: BSD-3-Clause
// `hils board` and `hils run --fcu NAME` on stand-ins for boards: each outcome, and interference of
// others.
#include <gmock/gmock.h>
#include <signal.h>

#include <filesystem>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/loopback/board_shelf.hpp"
#include "tests/loopback/scripted_vehicle.hpp"
#include "tests/support/ended_with.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/terminal_program.hpp"
#include "tests/support/wait_until.hpp"

namespace cas::test {
namespace {

using nlohmann::json;
using testing::HasSubstr;
using testing::Not;

// Exit codes of hils.
constexpr int kUsage = 2;
constexpr int kAbsent = 4;
constexpr int kNoBoot = 5;
constexpr int kFailed = 6;
constexpr int kBusy = 7;

json listed(const BoardShelf& shelf, std::size_t place = 0) {
  const Ended list = shelf.board({"list", "--json"});
  EXPECT_EQ(list.code, 0) << list.output;
  return json::parse(list.output).at(place);
}

TEST(BoardProgram, FindsBoardsByTheirSerialNumberAndWaitsForTheirBoot) {
  const BoardShelf shelf({"a firmware: 1.15, calibration: done", "b"});
  EXPECT_FALSE(listed(shelf).at("present"));
  EXPECT_THAT(shelf.board({"power", "on", "a"}),
              EndedWith(0, "board 'a' has booted: PX4 1.15.0, in HIL, disarmed"));
  EXPECT_EQ(listed(shelf).at("device"), shelf.link("a").string());
  EXPECT_EQ(listed(shelf).at("calibration"), "done");
  EXPECT_FALSE(listed(shelf, 1).at("present"));
  EXPECT_THAT(shelf.board({"list"}).output,
              testing::AllOf(HasSubstr("absent"), HasSubstr("it is free")));
  EXPECT_EQ(shelf.board({"list", "--names"}).output, "a\nb\n");
  EXPECT_EQ(shelf.board({"power", "off", "a"}).code, 0);
  EXPECT_FALSE(listed(shelf).at("present"));
}

TEST(BoardProgram, TellsABoardThatDoesNotComeFromOneThatDoesNotBoot) {
  const BoardShelf shelf({"a boot_timeout_s: 2"});
  shelf.set_defect("a", "absent");
  EXPECT_THAT(shelf.board({"power", "on", "a"}),
              EndedWith(kAbsent,
                        "board 'a' is not there: no serial port of a USB device with the serial "
                        "number SN1"));
  shelf.set_defect("a", "silent");
  EXPECT_THAT(shelf.board({"power", "on", "a"}),
              EndedWith(kNoBoot, "board 'a' does not boot: no HEARTBEAT comes from " +
                                     shelf.link("a").string()));
}

TEST(BoardProgram, WaitsForABoardThatBootsSlowly) {
  const BoardShelf shelf;
  shelf.set_defect("a", "slow");
  EXPECT_THAT(shelf.board({"power", "cycle", "a"}), EndedWith(0, "has booted"));
}

TEST(BoardProgram, FindsTheWrongFirmware) {
  const BoardShelf shelf({"a firmware: 1.14, boot_timeout_s: 60"});
  EXPECT_THAT(shelf.board({"power", "on", "a"}),
              EndedWith(kNoBoot, "board 'a' runs firmware 1.15.0 instead of 1.14"));
  const std::string file = shelf.folder.write("new.px4", "-").string();
  const Ended flashed = shelf.board({"flash", "a", file, "--firmware", "1.15.0"});
  EXPECT_EQ(flashed.code, 0) << flashed.output;
  EXPECT_EQ(shelf.said("a.flashed"), file + "\n");
  EXPECT_THAT(shelf.board({"flash", "a", file, "--commit", "12ab"}),
              EndedWith(kNoBoot, "runs firmware of commit unknown instead of 12ab"));
}

TEST(BoardProgram, EndsAFlashToolThatHangsAndSaysWhatOneThatFailsSaid) {
  const BoardShelf shelf;
  const std::string file = shelf.folder.write("new.px4", "-").string();
  shelf.set_defect("a", "hang");
  EXPECT_THAT(
      shelf.board({"flash", "a", file}),
      EndedWith(kFailed,
                "hook flash of board 'a' was not done within 5 s and was ended; its last lines:"
                "\n    erasing"));
  shelf.set_defect("a", "broken");
  EXPECT_THAT(
      shelf.board({"flash", "a", file}),
      EndedWith(kFailed, "ended with exit code 3; its last lines:\n    no bootloader answers"));
  EXPECT_THAT(shelf.board({"flash", "a"}), EndedWith(kUsage, "CAS_BOARD_FILE has no value here"));
  EXPECT_FALSE(listed(shelf).at("held"));
}

TEST(BoardProgram, RestartsABoardByItsCommandAndASilentOneByItsButton) {
  const BoardShelf shelf;
  ASSERT_EQ(shelf.board({"power", "on", "a"}).code, 0);
  EXPECT_THAT(shelf.board({"reboot", "a"}), EndedWith(0));
  EXPECT_NE(shelf.said("a.log").find("reboot by command"), std::string::npos);
  const std::string before = shelf.said("a.pid");
  shelf.hang("a");
  EXPECT_THAT(shelf.board({"reboot", "a"}), EndedWith(0));
  EXPECT_NE(shelf.said("a.pid"), before);
}

TEST(BoardProgram, BelievesNoHookThatDidNotRestartTheBoard) {
  const BoardShelf shelf({"a", "b"});
  ASSERT_EQ(shelf.board({"power", "on", "a"}).code, 0);
  ASSERT_EQ(shelf.board({"power", "on", "b"}).code, 0);
  shelf.set_defect("a", "stuck");
  shelf.set_defect("b", "stuck");
  const auto reset = shelf.start({"board", "reboot", "a", "--hard"});
  EXPECT_THAT(shelf.board({"power", "cycle", "b"}),
              EndedWith(kFailed, "board 'b' still says HEARTBEAT after its power was cut"));
  EXPECT_EQ(reset->wait_exit(), kNoBoot) << reset->output();
  EXPECT_NE(reset->output().find("board 'a' did not restart"), std::string::npos);
}

/// A casd on the board's port, as a user may have one beside `hils board`.
class Neighbour {
 public:
  explicit Neighbour(const BoardShelf& shelf)
      : address_("unix:" + (shelf.folder / "casd.sock").string()),
        casd_({binary_dir() + "/bin/casd",
               shelf.folder
                   .write("casd.yaml", "schema: 1\ncommand_port: {unix: '" +
                                           (shelf.folder / "casd.sock").string() +
                                           "', port: 0, loopback_without_token: true}\nlinks:\n"
                                           "  - {name: fcu, type: serial, device: '" +
                                           shelf.link("a").string() + "'}\n")
                   .string()}) {
    EXPECT_TRUE(casd_.wait_ready()) << casd_.output();
  }
  Ended casctl(std::vector<std::string> words) const {
    words.insert(words.begin(), {binary_dir() + "/bin/casctl", "--address", address_});
    return ChildProcess(words).end(std::chrono::seconds(60));
  }

 private:
  std::string address_;
  ChildProcess casd_;
};

TEST(BoardProgram, RestartsAndFlashesNoArmedBoard) {
  const BoardShelf shelf;
  ASSERT_EQ(shelf.board({"power", "on", "a"}).code, 0);
  const std::string stand_in = shelf.said("a.pid");
  {
    const Neighbour neighbour(shelf);
    ASSERT_THAT(neighbour.casctl({"arm", "--force", "--wait"}), EndedWith(0));
    EXPECT_THAT(shelf.board({"reboot", "a", "--hard"}), EndedWith(kAbsent, "cannot be opened: "));
  }
  const std::vector<std::vector<std::string>> refused_verbs{
      {"reboot", "a"},
      {"reboot", "a", "--hard"},
      {"power", "cycle", "a"},
      {"flash", "a", (shelf.folder / "boards.yaml").string()}};
  for (const std::vector<std::string>& words : refused_verbs) {
    EXPECT_THAT(shelf.board(words), EndedWith(kFailed, "board 'a' is armed: disarm it first"));
  }
  EXPECT_EQ(shelf.said("a.pid"), stand_in);
  EXPECT_EQ(shelf.board({"power", "cycle", "a", "--force"}).code, 0);
  EXPECT_NE(shelf.said("a.pid"), stand_in);
  EXPECT_EQ(shelf.board({"power", "off", "a"}).code, 0);
}

TEST(BoardProgram, PutsItsUserOnTheConsole) {
  const BoardShelf shelf;
  ASSERT_EQ(shelf.board({"power", "on", "a"}).code, 0);
  const Ended console = shelf.board({"console", "a"});
  EXPECT_EQ(console.code, 0) << console.output;
  EXPECT_EQ(console.output, "console of " + shelf.link("a").string() + "\n0\n")
      << "its working folder is that of boards.yaml";
}

TEST(BoardProgram, HoldsABoardUntilItIsUnlocked) {
  const BoardShelf shelf;
  const Ended lock = shelf.board({"lock", "a", "--for", "the night"});
  ASSERT_EQ(lock.code, 0) << lock.output;
  ASSERT_EQ(lock.output.find("CAS_BOARD_HOLDER="), 0U) << lock.output;
  const std::string ticket = lock.output.substr(0, lock.output.find('\n'));
  EXPECT_EQ(listed(shelf).at("holder").at("for"), "hils board lock: the night");

  EXPECT_THAT(shelf.board({"power", "on", "a"}),
              EndedWith(kBusy, "board 'a' is not free: it is held by process ",
                        ": hils board lock: the night"));
  EXPECT_THAT(shelf.board({"power", "on", "a"}, {ticket}), EndedWith(0));

  EXPECT_EQ(shelf.board({"unlock", "a"}).code, 0);
  EXPECT_FALSE(listed(shelf).at("held"));
  EXPECT_EQ(shelf.board({"power", "off", "a"}).code, 0);
}

TEST(BoardProgram, CutsThePowerOfABoardThatSomebodyHolds) {
  const BoardShelf shelf;
  ASSERT_EQ(shelf.board({"power", "on", "a"}).code, 0);
  ASSERT_EQ(shelf.board({"lock", "a", "--for", "the night"}).code, 0);
  EXPECT_THAT(shelf.board({"power", "off", "a"}),
              EndedWith(0, ": hils board lock: the night; its power is cut all the same"));
  EXPECT_FALSE(listed(shelf).at("present"));
  EXPECT_EQ(shelf.board({"unlock", "a"}).code, 0);
}

TEST(BoardProgram, CutsThePowerOfABoardWhateverIsWrongWithItsLock) {
  const BoardShelf shelf;
  ASSERT_EQ(shelf.board({"power", "on", "a"}).code, 0);
  EXPECT_THAT(shelf.board({"power", "off", "a", "--wait"}), EndedWith(kUsage));
  EXPECT_TRUE(listed(shelf).at("present"));
  const std::filesystem::path folder = shelf.folder / "runtime/boards";
  const auto power_off_is_done = [&] {
    EXPECT_EQ(shelf.board({"power", "on", "a"}).code, kUsage);
    EXPECT_THAT(shelf.board({"power", "off", "a"}), EndedWith(0, "its power is cut all the same"));
    std::filesystem::remove_all(folder);
    EXPECT_FALSE(listed(shelf).at("present"));
  };
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder / "SN1.lock");  // cannot be opened for writing
  power_off_is_done();
  ASSERT_EQ(shelf.board({"power", "on", "a"}).code, 0);
  std::filesystem::remove_all(folder);
  shelf.folder.write("runtime/boards", "no folder");
  power_off_is_done();
}

TEST(BoardProgram, FreesTheBoardOfAHolderThatWasKilled) {
  const BoardShelf shelf;
  ASSERT_EQ(shelf.board({"lock", "a"}).code, 0);
  ASSERT_EQ(::kill(listed(shelf).at("holder").at("pid").get<int>(), SIGKILL), 0);
  EXPECT_TRUE(wait_until([&] { return !listed(shelf).at("held").get<bool>(); }));
}

TEST(BoardProgram, HoldsABoardWhileACommandRuns) {
  const BoardShelf shelf;
  std::string inside;
  for (const std::string& word : shelf.command({"board", "power", "off", "a"})) {
    inside += "'" + word + "' ";
  }
  EXPECT_THAT(shelf.board({"lock", "a", "--", "sh", "-c", inside + " && echo \"was $?\"; exit 9"}),
              EndedWith(9, "was 0"));
  EXPECT_FALSE(listed(shelf).at("held"));
}

TEST(BoardProgram, HoldsABoardAsLongAsAnythingBelowTheLockRuns) {
  const BoardShelf shelf;
  const std::string go = (shelf.folder / "go").string();
  EXPECT_THAT(
      shelf.board({"lock", "a", "--", "sh", "-c",
                   "(while [ ! -e '" + go + "' ]; do sleep 0.05; done) >/dev/null 2>&1 & exit 0"}),
      EndedWith(0));
  EXPECT_EQ(shelf.board({"power", "on", "a"}).code, kBusy);
  EXPECT_THAT(
      shelf.board({"unlock", "a", "--force"}),
      EndedWith(kBusy, " has ended; what it started holds it since ", " (sh)", "; end that"));
  EXPECT_THAT(shelf.board({"list"}).output,
              HasSubstr(" has ended; what it started holds it since "));
  shelf.folder.write("go", "-");
  EXPECT_TRUE(wait_until([&] { return !listed(shelf).at("held").get<bool>(); }));
}

TEST(BoardProgram, EndsAllThatRunsBelowTheLock) {
  const BoardShelf shelf;
  const std::string there = (shelf.folder / "there").string();
  const std::string ended = (shelf.folder / "ended").string();
  const auto lock = shelf.start({"board", "lock", "a", "--", "sh", "-c",
                                 "sh -c \"trap 'echo yes >" + ended + "; exit' TERM; echo >" +
                                     there + "; while true; do sleep 0.05; done\"; true"});
  ASSERT_TRUE(wait_until([&] { return !shelf.said("there").empty(); })) << lock->output();
  EXPECT_THAT(shelf.board({"unlock", "a"}), EndedWith(kBusy, "--force ends that program"));
  EXPECT_THAT(shelf.board({"unlock", "a", "--force"}), EndedWith(0));
  EXPECT_TRUE(lock->wait_exit()) << lock->output();
  EXPECT_EQ(shelf.said("ended"), "yes\n");
}

TEST(BoardProgram, KeepsABoardForWhatUsesItBelowALockThatEnds) {
  const BoardShelf shelf({"a boot_timeout_s: 600"});
  const Ended lock = shelf.board({"lock", "a"});
  ASSERT_EQ(lock.code, 0) << lock.output;
  shelf.set_defect("a", "silent");
  const auto guest =
      shelf.start({"board", "power", "on", "a"}, {lock.output.substr(0, lock.output.find('\n'))});
  ASSERT_TRUE(wait_until([&] { return listed(shelf).at("guests").get<bool>(); }))
      << guest->output();
  EXPECT_THAT(shelf.board({"unlock", "a"}), EndedWith(0, "is free once the program ends"));
  EXPECT_THAT(shelf.board({"reboot", "a"}),
              EndedWith(kBusy, "it is in use below a lock that has ended"));
  guest->signal(SIGTERM);
  EXPECT_TRUE(guest->wait_exit()) << guest->output();
  EXPECT_FALSE(listed(shelf).at("held"));
}

TEST(BoardProgram, EndsNoProcessThatALockFileOnlyNames) {
  const BoardShelf shelf;
  ASSERT_EQ(shelf.board({"lock", "a"}).code, 0);
  const ChildProcess bystander({"/bin/sleep", "1000"});
  const std::string file = (shelf.folder / "runtime/boards/SN1.lock").string();
  const std::string text = TemporaryFolder::read(file);
  ASSERT_EQ(text.find("pid "), 0U) << text;
  std::ofstream(file) << "pid " << bystander.pid() << text.substr(text.find('\n'));
  const Ended unlock = shelf.board({"unlock", "a", "--force"});
  EXPECT_THAT(unlock, EndedWith(kBusy, "does not have " + file + " open", " (hils)"));
  EXPECT_EQ(::kill(bystander.pid(), 0), 0);
  std::ofstream(file) << text;
  EXPECT_EQ(shelf.board({"unlock", "a"}).code, 0);
}

TEST(BoardProgram, SeesTheEndOfACommandWhereItsParentIgnoresChildren) {
  const BoardShelf shelf;
  EXPECT_THAT(shelf.board({"lock", "a", "--", "sh", "-c", "exit 9"}, {"--ignore-signal=CHLD"}),
              EndedWith(9));
}

TEST(BoardProgram, LeavesTheKeysOfTheTerminalToTheCommandAndTheScriptAroundIt) {
  const BoardShelf shelf;
  std::string script;
  for (const std::string& word : shelf.command({"board", "lock", "a", "--", "cat"})) {
    script += "'" + word + "' ";
  }
  const std::string file = shelf.folder.write("job", script + "\necho went on\n").string();
  TerminalProgram shell({"/bin/sh", "-i"}, 24, 250);
  shell.press("sh " + file + "\n");
  ASSERT_TRUE(wait_until([&] { return listed(shelf).at("held").get<bool>(); })) << shell.text();
  shell.press("one\n");
  EXPECT_TRUE(shell.shows("one\none\n")) << shell.text();
  shell.press("\x1a");  // Ctrl-Z
  EXPECT_TRUE(shell.shows("Stopped")) << shell.text();
  shell.press("echo shell-$((1 + 1))\n");
  EXPECT_TRUE(shell.shows("shell-2")) << shell.text();
  shell.press("fg\n");
  EXPECT_TRUE(wait_until([&] {
    const std::string text = shell.text();
    return text.rfind("/job\n") > text.rfind("fg\n");
  })) << shell.text();
  shell.press("two\n");
  EXPECT_TRUE(shell.shows("two\ntwo\n")) << shell.text();
  shell.press("\x03");  // Ctrl-C
  EXPECT_TRUE(wait_until([&] { return !listed(shelf).at("held").get<bool>(); })) << shell.text();
  shell.press("echo code-$?\n");
  EXPECT_TRUE(shell.shows("code-130")) << shell.text();
  EXPECT_THAT(shell.text(), Not(HasSubstr("went on")));
}

TEST(BoardProgram, UnlocksNoBoardThatIsAtWorkUnlessForced) {
  const BoardShelf shelf({"a boot_timeout_s: 600"});
  shelf.set_defect("a", "silent");
  const auto at_work = shelf.start({"board", "power", "on", "a"});
  ASSERT_TRUE(wait_until([&] { return listed(shelf).contains("holder"); })) << at_work->output();
  EXPECT_THAT(shelf.board({"unlock", "a"}), EndedWith(kBusy, "--force ends that program"));
  EXPECT_THAT(shelf.board({"unlock", "a", "--force"}), EndedWith(0));
  EXPECT_TRUE(at_work->wait_exit()) << at_work->output();
}

TEST(BoardProgram, GivesABoardToWaitersInTheOrderOfTheirComing) {
  const BoardShelf shelf;
  ASSERT_EQ(shelf.board({"lock", "a"}).code, 0);
  const std::string order = (shelf.folder / "order").string();
  std::vector<std::unique_ptr<ChildProcess>> waiters;
  for (const char* name : {"first", "second", "third"}) {
    waiters.push_back(shelf.start({"board", "lock", "a", "--wait", "--", "sh", "-c",
                                   "echo " + std::string(name) + " >>" + order}));
    ASSERT_TRUE(wait_until([&] { return listed(shelf).at("waiting") == waiters.size(); }))
        << waiters.back()->output();
  }
  EXPECT_THAT(shelf.board({"power", "on", "a", "--wait=0.3"}),
              EndedWith(kBusy, "board 'a' is not free after 0.3 s: "));
  EXPECT_EQ(shelf.board({"unlock", "a"}).code, 0);
  for (const auto& waiter : waiters) EXPECT_EQ(waiter->wait_exit(), 0) << waiter->output();
  EXPECT_EQ(shelf.said("order"), "first\nsecond\nthird\n");
}

TEST(BoardProgram, FetchesTheNewestLogOfABoard) {
  const BoardShelf shelf({"a log: {folder: files, largest_mib: 1, timeout_s: 20}",
                          "b log: {folder: files/none}", "c"});
  ASSERT_EQ(shelf.board({"power", "on", "a"}).code, 0);
  ASSERT_EQ(shelf.board({"power", "on", "b"}).code, 0);
  const std::string newest = "ULog of the second flight " + std::string(5000, '7');
  shelf.folder.write("logs/sess099/log001.ulg", "without a clock");
  shelf.folder.write("logs/2026-03-01/12_00_00.ulg", "the first flight");
  shelf.folder.write("logs/2026-03-01/13_30_00.ulg", newest);
  shelf.folder.write("logs/2026-03-01/13_40_00.txt", "no log");
  shelf.folder.write("logs/2026-03-02/.ulg", "hidden");
  const std::string file = (shelf.folder / "a.ulg").string();
  EXPECT_THAT(
      shelf.board({"log", "a", file}),
      EndedWith(0,
                "board 'a': its newest log is in a.ulg: files/2026-03-01/13_30_00.ulg, 5026 "
                "bytes; it may be of an earlier flight"));
  EXPECT_EQ(shelf.said("a.ulg"), newest);

  shelf.folder.write("logs/2026-03-03/too_large.ulg", std::string(2 << 20, '.'));
  EXPECT_THAT(shelf.board({"log", "a", file}),
              EndedWith(kFailed, "too_large.ulg has 2.0 MiB, and its `largest_mib` is 1"));
  EXPECT_EQ(shelf.said("a.ulg"), newest) << "what was there stays";
  EXPECT_THAT(shelf.board({"log", "b", file}),
              EndedWith(kFailed, "board 'b': its log was not fetched: "));
  EXPECT_THAT(shelf.board({"log", "c"}), EndedWith(kUsage, "board 'c' has no `log`"));
}

const std::string kHover = source_dir() + "/config/scenarios/hover.yaml";

TEST(BoardRun, ThatFindsNoBoardEndsWithACodeOfItsOwnAndAJunitFile) {
  const BoardShelf shelf({"a firmware: 1.14"});
  const std::string out = (shelf.folder / "out").string();
  const auto fly = [&](const std::string& fcu) {
    return shelf.hils({"run", kHover, "--fcu", fcu, "--out", out});
  };
  EXPECT_THAT(fly("a"), EndedWith(kAbsent));
  EXPECT_THAT(shelf.said("out/junit.xml"),
              HasSubstr("<error message=\"board &apos;a&apos; is not there"));
  ASSERT_EQ(shelf.board({"power", "on", "a"}).code, kNoBoot);
  EXPECT_THAT(fly("a"), EndedWith(kNoBoot));
  EXPECT_THAT(shelf.said("out/junit.xml"), HasSubstr("runs firmware 1.15.0 instead of 1.14"));
  ASSERT_EQ(shelf.board({"lock", "a"}).code, 0);
  EXPECT_THAT(fly("a"), EndedWith(kBusy));
  EXPECT_THAT(shelf.said("out/junit.xml"),
              HasSubstr("<error message=\"board &apos;a&apos; is not free"));
  EXPECT_THAT(fly(shelf.link("a").string()), EndedWith(kBusy));
  EXPECT_EQ(shelf.board({"unlock", "a"}).code, 0);
  EXPECT_THAT(fly("aa"), EndedWith(kUsage, "there is no board 'aa'"));
}

TEST(BoardRun, ThatNamesNoControllerSaysSoAndLeavesNoFolder) {
  const BoardShelf shelf;
  const std::string none = (shelf.folder / "none").string();
  const std::string file = shelf.folder.write("file", "-").string();
  const auto fly = [&](const std::string& fcu) {
    return ChildProcess({"/usr/bin/env", "-C", shelf.folder / "runtime",
                         "CAS_BOARDS=", "XDG_CONFIG_HOME=" + none, binary_dir() + "/bin/hils",
                         "run", kHover, "--fcu", fcu, "--out", none})
        .end();
  };
  EXPECT_THAT(
      fly("a"),
      EndedWith(kUsage, "--fcu a: no port of the working folder has this name, and there is no",
                "there is no " + none + "/cas/boards.yaml or /etc/cas/boards.yaml"));
  for (const std::string& no_terminal : {file, std::string("/dev/null")}) {
    EXPECT_THAT(fly(no_terminal), EndedWith(kUsage, no_terminal + " is not a terminal"));
  }
  EXPECT_FALSE(std::filesystem::exists(none));
}

/// A campaign that would let one failure strike in the hover, and its file.
std::string campaign(const BoardShelf& shelf, const std::string& failures) {
  return shelf.folder
      .write("campaign.yaml", "schema: 1\nname: one\nscenario: " + kHover +
                                  "\nphases: {hover: phase == hold}\nfailures:\n" + failures)
      .string();
}

TEST(BoardCampaign, ThatFindsNoBoardEndsWithItsCodeAndAReport) {
  const BoardShelf shelf;
  const std::string file = campaign(shelf,
                                    "  - {failure: gps_lost, expect: [no_crash]}\n"
                                    "  - {failure: line_cut, expect: [no_crash]}\n"
                                    "  - {failure: cpu_starved, expect: [no_crash]}\n");
  const std::string out = (shelf.folder / "out").string();
  const auto fly = [&](const std::string& fcu) {
    return shelf.hils({"campaign", file, "--fcu", fcu, "--out", out});
  };
  EXPECT_THAT(fly("a"), EndedWith(kAbsent, "board 'a' is not there",
                                  "0 of 1 cells as expected, 0 missed, 1 without a verdict",
                                  "line_cut: not flown; it needs the emulated line",
                                  "cpu_starved: not flown; it needs the virtual clock"));
  const std::string junit = shelf.said("out/junit.xml");
  EXPECT_THAT(junit,
              HasSubstr("name=\"board\" time=\"0\"><error message=\"board &apos;a&apos; is not"));
  EXPECT_THAT(junit, HasSubstr("tests=\"4\" failures=\"0\" errors=\"2\" skipped=\"2\""));
  EXPECT_THAT(shelf.said("out/campaign.html"), HasSubstr("not flown"));

  ASSERT_EQ(shelf.board({"lock", "a"}).code, 0);
  EXPECT_THAT(fly("a"), EndedWith(kBusy));
  EXPECT_EQ(shelf.board({"unlock", "a"}).code, 0);
  EXPECT_THAT(shelf.hils({"sweep", "run", out}),
              EndedWith(kUsage, "is flown with boards, by 'hils campaign"));
  for (const std::vector<std::string>& words :
       {std::vector<std::string>{"sweep", "show", out, "1"}, {"sweep", "collect", out}}) {
    EXPECT_THAT(shelf.hils(words), EndedWith(kUsage, "is flown with boards, by 'hils campaign"));
  }
  const Ended by_clock = shelf.hils({"campaign", file, "--out", out, "--plan"});
  EXPECT_EQ(by_clock.code, 0) << "nothing was flown: the folder is free\n" << by_clock.output;
}

TEST(BoardCampaign, RestartsNoVehicleThatSaysThatItIsNotInHil) {
  const BoardShelf shelf;
  const std::string file = campaign(shelf, "  - {failure: gps_lost, expect: [no_crash]}\n");
  shelf.folder.write("out/again/row_1/run/casd.log", "of a flight that was interrupted");
  PtyPair line(shelf.folder / "line");
  ScriptedVehicle vehicle(line, [](casd::test::FakeVehicle& its) {
    its.base_mode = mavlink::common::MavModeFlag::kCustomModeEnabled |
                    mavlink::common::MavModeFlag::kSafetyArmed;
  });
  EXPECT_THAT(shelf.hils({"campaign", file, "--fcu", (shelf.folder / "line").string(), "--out",
                          (shelf.folder / "out").string()}),
              EndedWith(kFailed, "does not say that it is in HIL: it is not restarted"));
  for (const auto& command : vehicle.stop().commands) {
    EXPECT_NE(command.command, mavlink::common::MavCmd::kComponentArmDisarm);
    EXPECT_NE(command.command, mavlink::common::MavCmd::kPreflightRebootShutdown);
  }
}

TEST(BoardCampaign, IsRefusedWithAReason) {
  const BoardShelf shelf;
  const std::string file = campaign(shelf, "  - {failure: line_cut, expect: [no_crash]}\n");
  const auto refusal = [&](const std::vector<std::string>& more) {
    std::vector<std::string> words{"campaign", file, "--out", (shelf.folder / "out").string()};
    words.insert(words.end(), more.begin(), more.end());
    const Ended answer = shelf.hils(words);
    EXPECT_EQ(answer.code, kUsage) << answer.output;
    return answer.output;
  };
  EXPECT_THAT(refusal({"--fcu", "a"}), HasSubstr("failures: has nothing that can be flown"));
  EXPECT_THAT(refusal({"--boards", "boards.yaml"}), HasSubstr("belong to --fcu"));
  EXPECT_THAT(refusal({"--only", "gps_lots"}), HasSubstr("has no failure 'gps_lots'"));
  campaign(shelf, "  - {failure: gps_lost, expect: [no_crash]}\n");
  EXPECT_THAT(refusal({"--fcu", "a", "--plan"}), HasSubstr("--plan: a campaign with boards"));
  EXPECT_THAT(refusal({"--fcu", "a", "--jobs", "2"}), HasSubstr("--jobs: with boards"));
  EXPECT_THAT(refusal({"--fcu", "aa"}), HasSubstr("there is no board 'aa'"));
  EXPECT_THAT(refusal({"--fcu", "right=a"}), HasSubstr("there is no vehicle 'right'"));
}

TEST(BoardRun, OfSeveralVehiclesWantsToKnowWhichIsWhich) {
  const BoardShelf shelf;
  const std::string two = source_dir() + "/config/scenarios/two_vehicles.yaml";
  const std::string out = (shelf.folder / "out").string();
  EXPECT_THAT(shelf.hils({"run", two, "--fcu", "a", "--out", out}),
              EndedWith(kUsage, "the scenario has several vehicles: say which one"));
}

}  // namespace
}  // namespace cas::test
