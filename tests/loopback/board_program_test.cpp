// SPDX-License-Identifier: BSD-3-Clause
// `hils board` and `hils run --fcu NAME` on stand-ins for boards: each outcome, and interference of
// others.
#include <gtest/gtest.h>
#include <signal.h>

#include <filesystem>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/loopback/board_shelf.hpp"
#include "tests/loopback/scripted_vehicle.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/terminal_program.hpp"
#include "tests/support/wait_until.hpp"

namespace cas::test {
namespace {

using nlohmann::json;

// Exit codes of hils.
constexpr int kUsage = 2;
constexpr int kAbsent = 4;
constexpr int kNoBoot = 5;
constexpr int kFailed = 6;
constexpr int kBusy = 7;

#define EXPECT_SAYS(answer, words) \
  EXPECT_NE((answer).text.find(words), std::string::npos) << (answer).text

json listed(const BoardShelf& shelf, std::size_t place = 0) {
  const ShelfAnswer list = shelf.board({"list", "--json"});
  EXPECT_EQ(list.code, 0) << list.text;
  return json::parse(list.text).at(place);
}

TEST(BoardProgram, FindsBoardsByTheirSerialNumberAndWaitsForTheirBoot) {
  const BoardShelf shelf({"a firmware: 1.15, calibration: done", "b"});
  EXPECT_FALSE(listed(shelf).at("present"));
  const ShelfAnswer on = shelf.board({"power", "on", "a"});
  EXPECT_EQ(on.code, 0) << on.text;
  EXPECT_SAYS(on, "board 'a' has booted: PX4 1.15.0, in HIL, disarmed");
  EXPECT_EQ(listed(shelf).at("device"), shelf.link("a").string());
  EXPECT_EQ(listed(shelf).at("calibration"), "done");
  EXPECT_FALSE(listed(shelf, 1).at("present"));
  const ShelfAnswer table = shelf.board({"list"});
  EXPECT_SAYS(table, "absent");
  EXPECT_SAYS(table, "it is free");
  EXPECT_EQ(shelf.board({"list", "--names"}).text, "a\nb\n");
  EXPECT_EQ(shelf.board({"power", "off", "a"}).code, 0);
  EXPECT_FALSE(listed(shelf).at("present"));
}

TEST(BoardProgram, TellsABoardThatDoesNotComeFromOneThatDoesNotBoot) {
  const BoardShelf shelf({"a boot_timeout_s: 2"});
  shelf.set_defect("a", "absent");
  const ShelfAnswer absent = shelf.board({"power", "on", "a"});
  EXPECT_EQ(absent.code, kAbsent) << absent.text;
  EXPECT_SAYS(absent,
              "board 'a' is not there: no serial port of a USB device with the serial "
              "number SN1");
  shelf.set_defect("a", "silent");
  const ShelfAnswer silent = shelf.board({"power", "on", "a"});
  EXPECT_EQ(silent.code, kNoBoot) << silent.text;
  EXPECT_SAYS(silent,
              "board 'a' does not boot: no HEARTBEAT comes from " + shelf.link("a").string());
}

TEST(BoardProgram, WaitsForABoardThatBootsSlowly) {
  const BoardShelf shelf;
  shelf.set_defect("a", "slow");
  const ShelfAnswer slow = shelf.board({"power", "cycle", "a"});
  EXPECT_EQ(slow.code, 0) << slow.text;
  EXPECT_SAYS(slow, "has booted");
}

TEST(BoardProgram, FindsTheWrongFirmware) {
  const BoardShelf shelf({"a firmware: 1.14, boot_timeout_s: 60"});
  const ShelfAnswer wrong = shelf.board({"power", "on", "a"});
  EXPECT_EQ(wrong.code, kNoBoot) << wrong.text;
  EXPECT_SAYS(wrong, "board 'a' runs firmware 1.15.0 instead of 1.14");
  const std::string file = shelf.folder.write("new.px4", "-").string();
  const ShelfAnswer flashed = shelf.board({"flash", "a", file, "--firmware", "1.15.0"});
  EXPECT_EQ(flashed.code, 0) << flashed.text;
  EXPECT_EQ(shelf.said("a.flashed"), file + "\n");
  const ShelfAnswer commit = shelf.board({"flash", "a", file, "--commit", "12ab"});
  EXPECT_EQ(commit.code, kNoBoot) << commit.text;
  EXPECT_SAYS(commit, "runs firmware of commit unknown instead of 12ab");
}

TEST(BoardProgram, EndsAFlashToolThatHangsAndSaysWhatOneThatFailsSaid) {
  const BoardShelf shelf;
  const std::string file = shelf.folder.write("new.px4", "-").string();
  shelf.set_defect("a", "hang");
  const ShelfAnswer hung = shelf.board({"flash", "a", file});
  EXPECT_EQ(hung.code, kFailed) << hung.text;
  EXPECT_SAYS(hung,
              "hook flash of board 'a' was not done within 5 s and was ended; its last lines:"
              "\n    erasing");
  shelf.set_defect("a", "broken");
  const ShelfAnswer broken = shelf.board({"flash", "a", file});
  EXPECT_EQ(broken.code, kFailed) << broken.text;
  EXPECT_SAYS(broken, "ended with exit code 3; its last lines:\n    no bootloader answers");
  const ShelfAnswer no_file = shelf.board({"flash", "a"});
  EXPECT_EQ(no_file.code, kUsage) << no_file.text;
  EXPECT_SAYS(no_file, "CAS_BOARD_FILE has no value here");
  EXPECT_FALSE(listed(shelf).at("held"));
}

TEST(BoardProgram, RestartsABoardByItsCommandAndASilentOneByItsButton) {
  const BoardShelf shelf;
  ASSERT_EQ(shelf.board({"power", "on", "a"}).code, 0);
  const ShelfAnswer restarted = shelf.board({"reboot", "a"});
  EXPECT_EQ(restarted.code, 0) << restarted.text;
  EXPECT_NE(shelf.said("a.log").find("reboot by command"), std::string::npos);
  const std::string before = shelf.said("a.pid");
  shelf.hang("a");
  const ShelfAnswer reset = shelf.board({"reboot", "a"});
  EXPECT_EQ(reset.code, 0) << reset.text;
  EXPECT_NE(shelf.said("a.pid"), before);
}

TEST(BoardProgram, BelievesNoHookThatDidNotRestartTheBoard) {
  const BoardShelf shelf({"a", "b"});
  ASSERT_EQ(shelf.board({"power", "on", "a"}).code, 0);
  ASSERT_EQ(shelf.board({"power", "on", "b"}).code, 0);
  shelf.set_defect("a", "stuck");
  shelf.set_defect("b", "stuck");
  const auto reset = shelf.start({"board", "reboot", "a", "--hard"});
  const ShelfAnswer cycle = shelf.board({"power", "cycle", "b"});
  EXPECT_EQ(cycle.code, kFailed) << cycle.text;
  EXPECT_SAYS(cycle, "board 'b' still says HEARTBEAT after its power was cut");
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
  ShelfAnswer casctl(std::vector<std::string> words) const {
    words.insert(words.begin(), {binary_dir() + "/bin/casctl", "--address", address_});
    ChildProcess child(words);
    const int code = child.wait_exit(std::chrono::seconds(60)).value_or(-1);
    return {code, child.output()};
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
    const ShelfAnswer armed = neighbour.casctl({"arm", "--force", "--wait"});
    ASSERT_EQ(armed.code, 0) << armed.text;
    const ShelfAnswer in_use = shelf.board({"reboot", "a", "--hard"});
    EXPECT_EQ(in_use.code, kAbsent) << in_use.text;
    EXPECT_SAYS(in_use, "cannot be opened: ");
  }
  const std::vector<std::vector<std::string>> refused_verbs{
      {"reboot", "a"},
      {"reboot", "a", "--hard"},
      {"power", "cycle", "a"},
      {"flash", "a", (shelf.folder / "boards.yaml").string()}};
  for (const std::vector<std::string>& words : refused_verbs) {
    const ShelfAnswer refused = shelf.board(words);
    EXPECT_EQ(refused.code, kFailed) << refused.text;
    EXPECT_SAYS(refused, "board 'a' is armed: disarm it first");
  }
  EXPECT_EQ(shelf.said("a.pid"), stand_in);
  EXPECT_EQ(shelf.board({"power", "cycle", "a", "--force"}).code, 0);
  EXPECT_NE(shelf.said("a.pid"), stand_in);
  EXPECT_EQ(shelf.board({"power", "off", "a"}).code, 0);
}

TEST(BoardProgram, PutsItsUserOnTheConsole) {
  const BoardShelf shelf;
  ASSERT_EQ(shelf.board({"power", "on", "a"}).code, 0);
  const ShelfAnswer console = shelf.board({"console", "a"});
  EXPECT_EQ(console.code, 0) << console.text;
  EXPECT_EQ(console.text, "console of " + shelf.link("a").string() + "\n0\n")
      << "its working folder is that of boards.yaml";
}

TEST(BoardProgram, HoldsABoardUntilItIsUnlocked) {
  const BoardShelf shelf;
  const ShelfAnswer lock = shelf.board({"lock", "a", "--for", "the night"});
  ASSERT_EQ(lock.code, 0) << lock.text;
  ASSERT_EQ(lock.text.find("CAS_BOARD_HOLDER="), 0U) << lock.text;
  const std::string ticket = lock.text.substr(0, lock.text.find('\n'));
  EXPECT_EQ(listed(shelf).at("holder").at("for"), "hils board lock: the night");

  const ShelfAnswer other = shelf.board({"power", "on", "a"});
  EXPECT_EQ(other.code, kBusy) << other.text;
  EXPECT_SAYS(other, "board 'a' is not free: it is held by process ");
  EXPECT_SAYS(other, ": hils board lock: the night");
  const ShelfAnswer own = shelf.board({"power", "on", "a"}, {ticket});
  EXPECT_EQ(own.code, 0) << own.text;

  EXPECT_EQ(shelf.board({"unlock", "a"}).code, 0);
  EXPECT_FALSE(listed(shelf).at("held"));
  EXPECT_EQ(shelf.board({"power", "off", "a"}).code, 0);
}

TEST(BoardProgram, CutsThePowerOfABoardThatSomebodyHolds) {
  const BoardShelf shelf;
  ASSERT_EQ(shelf.board({"power", "on", "a"}).code, 0);
  ASSERT_EQ(shelf.board({"lock", "a", "--for", "the night"}).code, 0);
  const ShelfAnswer off = shelf.board({"power", "off", "a"});
  EXPECT_EQ(off.code, 0) << off.text;
  EXPECT_SAYS(off, ": hils board lock: the night; its power is cut all the same");
  EXPECT_FALSE(listed(shelf).at("present"));
  EXPECT_EQ(shelf.board({"unlock", "a"}).code, 0);
}

TEST(BoardProgram, CutsThePowerOfABoardWhateverIsWrongWithItsLock) {
  const BoardShelf shelf;
  ASSERT_EQ(shelf.board({"power", "on", "a"}).code, 0);
  const ShelfAnswer waits = shelf.board({"power", "off", "a", "--wait"});
  EXPECT_EQ(waits.code, kUsage) << waits.text;
  EXPECT_TRUE(listed(shelf).at("present"));
  const std::filesystem::path folder = shelf.folder / "runtime/boards";
  const auto power_off_is_done = [&] {
    EXPECT_EQ(shelf.board({"power", "on", "a"}).code, kUsage);
    const ShelfAnswer off = shelf.board({"power", "off", "a"});
    EXPECT_EQ(off.code, 0) << off.text;
    EXPECT_SAYS(off, "its power is cut all the same");
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
  const ShelfAnswer command =
      shelf.board({"lock", "a", "--", "sh", "-c", inside + " && echo \"was $?\"; exit 9"});
  EXPECT_EQ(command.code, 9) << command.text;
  EXPECT_SAYS(command, "was 0");
  EXPECT_FALSE(listed(shelf).at("held"));
}

TEST(BoardProgram, HoldsABoardAsLongAsAnythingBelowTheLockRuns) {
  const BoardShelf shelf;
  const std::string go = (shelf.folder / "go").string();
  const ShelfAnswer command =
      shelf.board({"lock", "a", "--", "sh", "-c",
                   "(while [ ! -e '" + go + "' ]; do sleep 0.05; done) >/dev/null 2>&1 & exit 0"});
  EXPECT_EQ(command.code, 0) << command.text;
  EXPECT_EQ(shelf.board({"power", "on", "a"}).code, kBusy);
  const ShelfAnswer forced = shelf.board({"unlock", "a", "--force"});
  EXPECT_EQ(forced.code, kBusy) << forced.text;
  EXPECT_SAYS(forced, " has ended; what it started holds it since ");
  EXPECT_SAYS(forced, " (sh)");
  EXPECT_SAYS(forced, "; end that");
  EXPECT_SAYS(shelf.board({"list"}), " has ended; what it started holds it since ");
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
  const ShelfAnswer plain = shelf.board({"unlock", "a"});
  EXPECT_EQ(plain.code, kBusy) << plain.text;
  EXPECT_SAYS(plain, "--force ends that program");
  const ShelfAnswer forced = shelf.board({"unlock", "a", "--force"});
  EXPECT_EQ(forced.code, 0) << forced.text;
  EXPECT_TRUE(lock->wait_exit()) << lock->output();
  EXPECT_EQ(shelf.said("ended"), "yes\n");
}

TEST(BoardProgram, KeepsABoardForWhatUsesItBelowALockThatEnds) {
  const BoardShelf shelf({"a boot_timeout_s: 600"});
  const ShelfAnswer lock = shelf.board({"lock", "a"});
  ASSERT_EQ(lock.code, 0) << lock.text;
  shelf.set_defect("a", "silent");
  const auto guest =
      shelf.start({"board", "power", "on", "a"}, {lock.text.substr(0, lock.text.find('\n'))});
  ASSERT_TRUE(wait_until([&] { return listed(shelf).at("guests").get<bool>(); }))
      << guest->output();
  const ShelfAnswer unlock = shelf.board({"unlock", "a"});
  EXPECT_EQ(unlock.code, 0) << unlock.text;
  EXPECT_SAYS(unlock, "is free once the program ends");
  const ShelfAnswer other = shelf.board({"reboot", "a"});
  EXPECT_EQ(other.code, kBusy) << other.text;
  EXPECT_SAYS(other, "it is in use below a lock that has ended");
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
  const ShelfAnswer unlock = shelf.board({"unlock", "a", "--force"});
  EXPECT_EQ(unlock.code, kBusy) << unlock.text;
  EXPECT_SAYS(unlock, "does not have " + file + " open");
  EXPECT_SAYS(unlock, " (hils)");
  EXPECT_EQ(::kill(bystander.pid(), 0), 0);
  std::ofstream(file) << text;
  EXPECT_EQ(shelf.board({"unlock", "a"}).code, 0);
}

TEST(BoardProgram, SeesTheEndOfACommandWhereItsParentIgnoresChildren) {
  const BoardShelf shelf;
  const ShelfAnswer command =
      shelf.board({"lock", "a", "--", "sh", "-c", "exit 9"}, {"--ignore-signal=CHLD"});
  EXPECT_EQ(command.code, 9) << command.text;
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
  EXPECT_EQ(shell.text().find("went on"), std::string::npos) << shell.text();
}

TEST(BoardProgram, UnlocksNoBoardThatIsAtWorkUnlessForced) {
  const BoardShelf shelf({"a boot_timeout_s: 600"});
  shelf.set_defect("a", "silent");
  const auto at_work = shelf.start({"board", "power", "on", "a"});
  ASSERT_TRUE(wait_until([&] { return listed(shelf).contains("holder"); })) << at_work->output();
  const ShelfAnswer refused = shelf.board({"unlock", "a"});
  EXPECT_EQ(refused.code, kBusy) << refused.text;
  EXPECT_SAYS(refused, "--force ends that program");
  const ShelfAnswer forced = shelf.board({"unlock", "a", "--force"});
  EXPECT_EQ(forced.code, 0) << forced.text;
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
  const ShelfAnswer late = shelf.board({"power", "on", "a", "--wait=0.3"});
  EXPECT_EQ(late.code, kBusy) << late.text;
  EXPECT_SAYS(late, "board 'a' is not free after 0.3 s: ");
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
  const ShelfAnswer got = shelf.board({"log", "a", file});
  EXPECT_EQ(got.code, 0) << got.text;
  EXPECT_SAYS(got,
              "board 'a': its newest log is in a.ulg: files/2026-03-01/13_30_00.ulg, 5026 "
              "bytes; it may be of an earlier flight");
  EXPECT_EQ(shelf.said("a.ulg"), newest);

  shelf.folder.write("logs/2026-03-03/too_large.ulg", std::string(2 << 20, '.'));
  const ShelfAnswer large = shelf.board({"log", "a", file});
  EXPECT_EQ(large.code, kFailed) << large.text;
  EXPECT_SAYS(large, "too_large.ulg has 2.0 MiB, and its `largest_mib` is 1");
  EXPECT_EQ(shelf.said("a.ulg"), newest) << "what was there stays";
  const ShelfAnswer nowhere = shelf.board({"log", "b", file});
  EXPECT_EQ(nowhere.code, kFailed) << nowhere.text;
  EXPECT_SAYS(nowhere, "board 'b': its log was not fetched: ");
  const ShelfAnswer none = shelf.board({"log", "c"});
  EXPECT_EQ(none.code, kUsage) << none.text;
  EXPECT_SAYS(none, "board 'c' has no `log`");
}

const std::string kHover = source_dir() + "/config/scenarios/hover.yaml";

TEST(BoardRun, ThatFindsNoBoardEndsWithACodeOfItsOwnAndAJunitFile) {
  const BoardShelf shelf({"a firmware: 1.14"});
  const std::string out = (shelf.folder / "out").string();
  const auto fly = [&](const std::string& fcu) {
    return shelf.hils({"run", kHover, "--fcu", fcu, "--out", out});
  };
  const ShelfAnswer absent = fly("a");
  EXPECT_EQ(absent.code, kAbsent) << absent.text;
  EXPECT_NE(shelf.said("out/junit.xml").find("<error message=\"board &apos;a&apos; is not there"),
            std::string::npos)
      << shelf.said("out/junit.xml");
  ASSERT_EQ(shelf.board({"power", "on", "a"}).code, kNoBoot);
  const ShelfAnswer wrong = fly("a");
  EXPECT_EQ(wrong.code, kNoBoot) << wrong.text;
  EXPECT_NE(shelf.said("out/junit.xml").find("runs firmware 1.15.0 instead of 1.14"),
            std::string::npos);
  ASSERT_EQ(shelf.board({"lock", "a"}).code, 0);
  const ShelfAnswer held = fly("a");
  EXPECT_EQ(held.code, kBusy) << held.text;
  EXPECT_NE(shelf.said("out/junit.xml").find("<error message=\"board &apos;a&apos; is not free"),
            std::string::npos)
      << shelf.said("out/junit.xml");
  const ShelfAnswer by_port = fly(shelf.link("a").string());
  EXPECT_EQ(by_port.code, kBusy) << by_port.text;
  EXPECT_EQ(shelf.board({"unlock", "a"}).code, 0);
  const ShelfAnswer misspelt = fly("aa");
  EXPECT_EQ(misspelt.code, kUsage) << misspelt.text;
  EXPECT_SAYS(misspelt, "there is no board 'aa'");
}

TEST(BoardRun, ThatNamesNoControllerSaysSoAndLeavesNoFolder) {
  const BoardShelf shelf;
  const std::string none = (shelf.folder / "none").string();
  const std::string file = shelf.folder.write("file", "-").string();
  const auto fly = [&](const std::string& fcu) {
    ChildProcess hils({"/usr/bin/env", "-C", shelf.folder / "runtime",
                       "CAS_BOARDS=", "XDG_CONFIG_HOME=" + none, binary_dir() + "/bin/hils", "run",
                       kHover, "--fcu", fcu, "--out", none});
    const int code = hils.wait_exit().value_or(-1);
    return ShelfAnswer{code, hils.output()};
  };
  const ShelfAnswer no_list = fly("a");
  EXPECT_EQ(no_list.code, kUsage) << no_list.text;
  EXPECT_SAYS(no_list, "--fcu a: no port of the working folder has this name, and there is no");
  EXPECT_SAYS(no_list, "there is no " + none + "/cas/boards.yaml or /etc/cas/boards.yaml");
  for (const std::string& no_terminal : {file, std::string("/dev/null")}) {
    const ShelfAnswer refused = fly(no_terminal);
    EXPECT_EQ(refused.code, kUsage) << refused.text;
    EXPECT_SAYS(refused, no_terminal + " is not a terminal");
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
  const ShelfAnswer absent = fly("a");
  EXPECT_EQ(absent.code, kAbsent) << absent.text;
  EXPECT_SAYS(absent, "board 'a' is not there");
  EXPECT_SAYS(absent, "0 of 1 cells as expected, 0 missed, 1 without a verdict");
  EXPECT_SAYS(absent, "line_cut: not flown; it needs the emulated line");
  EXPECT_SAYS(absent, "cpu_starved: not flown; it needs the virtual clock");
  const std::string junit = shelf.said("out/junit.xml");
  EXPECT_NE(junit.find("name=\"board\" time=\"0\"><error message=\"board &apos;a&apos; is not"),
            std::string::npos)
      << junit;
  EXPECT_NE(junit.find("tests=\"4\" failures=\"0\" errors=\"2\" skipped=\"2\""), std::string::npos)
      << junit;
  EXPECT_NE(shelf.said("out/campaign.html").find("not flown"), std::string::npos);

  ASSERT_EQ(shelf.board({"lock", "a"}).code, 0);
  const ShelfAnswer held = fly("a");
  EXPECT_EQ(held.code, kBusy) << held.text;
  EXPECT_EQ(shelf.board({"unlock", "a"}).code, 0);
  const ShelfAnswer rows = shelf.hils({"sweep", "run", out});
  EXPECT_EQ(rows.code, kUsage) << rows.text;
  EXPECT_SAYS(rows, "is flown with boards, by 'hils campaign");
  for (const std::vector<std::string>& words :
       {std::vector<std::string>{"sweep", "show", out, "1"}, {"sweep", "collect", out}}) {
    const ShelfAnswer refused = shelf.hils(words);
    EXPECT_EQ(refused.code, kUsage) << refused.text;
    EXPECT_SAYS(refused, "is flown with boards, by 'hils campaign");
  }
  const ShelfAnswer by_clock = shelf.hils({"campaign", file, "--out", out, "--plan"});
  EXPECT_EQ(by_clock.code, 0) << "nothing was flown: the folder is free\n" << by_clock.text;
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
  const ShelfAnswer refused =
      shelf.hils({"campaign", file, "--fcu", (shelf.folder / "line").string(), "--out",
                  (shelf.folder / "out").string()});
  EXPECT_EQ(refused.code, kFailed) << refused.text;
  EXPECT_SAYS(refused, "does not say that it is in HIL: it is not restarted");
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
    const ShelfAnswer answer = shelf.hils(words);
    EXPECT_EQ(answer.code, kUsage) << answer.text;
    return answer;
  };
  EXPECT_SAYS(refusal({"--fcu", "a"}), "failures: has nothing that can be flown");
  EXPECT_SAYS(refusal({"--boards", "boards.yaml"}), "belong to --fcu");
  EXPECT_SAYS(refusal({"--only", "gps_lots"}), "has no failure 'gps_lots'");
  campaign(shelf, "  - {failure: gps_lost, expect: [no_crash]}\n");
  EXPECT_SAYS(refusal({"--fcu", "a", "--plan"}), "--plan: a campaign with boards");
  EXPECT_SAYS(refusal({"--fcu", "a", "--jobs", "2"}), "--jobs: with boards");
  EXPECT_SAYS(refusal({"--fcu", "aa"}), "there is no board 'aa'");
  EXPECT_SAYS(refusal({"--fcu", "right=a"}), "there is no vehicle 'right'");
}

TEST(BoardRun, OfSeveralVehiclesWantsToKnowWhichIsWhich) {
  const BoardShelf shelf;
  const std::string two = source_dir() + "/config/scenarios/two_vehicles.yaml";
  const std::string out = (shelf.folder / "out").string();
  const ShelfAnswer which = shelf.hils({"run", two, "--fcu", "a", "--out", out});
  EXPECT_EQ(which.code, kUsage) << which.text;
  EXPECT_SAYS(which, "the scenario has several vehicles: say which one");
}

}  // namespace
}  // namespace cas::test
