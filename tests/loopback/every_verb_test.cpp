// SPDX-License-Identifier: BSD-3-Clause
// Every verb of casctl against the emulated controller through casd, with nothing replaced.
#include <gtest/gtest.h>

#include <set>
#include <sstream>

#include "tests/loopback/emulator_fixture.hpp"
#include "tests/support/ended_with.hpp"
#include "tests/support/paths.hpp"

namespace cas::test {
namespace {

struct Verb {
  const char* name;
  std::vector<std::string> arguments;
  int code;
  const char* says;
};

/// On the ground, without a simulator: every verb with its result.
const std::vector<Verb>& verbs() {
  static const std::vector<Verb> list{
      {"status", {"status"}, 0, "PX4"},
      {"links", {"links"}, 0, "serial"},
      {"link add", {"link", "add", "udp:127.0.0.1:9"}, 0, "link udp added"},
      {"link remove", {"link", "remove", "udp"}, 0, "link udp removed"},
      {"routes", {"routes"}, 0, "only HEARTBEAT HIL_SENSOR HIL_GPS"},
      {"drops", {"drops"}, 0, ""},
      {"latency", {"latency"}, 0, "P99 us"},
      {"budget", {"budget"}, 0, "no limit"},
      {"param list", {"param", "list", "MC_ROLL"}, 0, "MC_ROLLRATE_P"},
      {"param get", {"param", "get", "SYS_HITL"}, 0, "SYS_HITL = 1"},
      {"param set", {"param", "set", "MC_ROLL_P", "6.4"}, 0, " -> 6.4"},
      {"param save", {"param", "save", "@params.txt"}, 0, "parameters saved to"},
      {"param load", {"param", "load", "@params.txt"}, 0, "are in force"},
      {"param load (a device)", {"param", "load", "/dev/zero"}, 1, "is no regular file"},
      {"gains", {"gains", "roll"}, 0, "6.4"},
      {"setgain", {"setgain", "roll", "6.5"}, 0, "roll: P 6.4 -> 6.5"},
      {"message-interval", {"message-interval", "ATTITUDE", "20"}, 0, "ATTITUDE at 20.0 Hz"},
      {"log start", {"log", "start", "flight"}, 0, "-flight.tlog"},
      {"log start (a path)", {"log", "start", "@flight.tlog"}, 1, "the folder for recordings"},
      {"log status", {"log", "status"}, 0, "recording into"},
      {"log stop", {"log", "stop"}, 0, "recorded"},
      {"reload", {"reload"}, 0, "read again"},
      {"mode", {"mode", "HOLD"}, 0, "took mode HOLD"},
      {"mode (wrong word)", {"mode", "NOPE"}, 1, "it has MANUAL"},
      {"arm", {"arm", "--no-wait"}, 1, "no accelerometer and gyro data"},
      {"disarm", {"disarm", "--wait"}, 0, "vehicle 1 disarmed"},
      {"takeoff", {"takeoff", "2"}, 0, "takes off to 2.0 m"},
      {"land", {"land"}, 0, "lands"},
      {"hold", {"hold"}, 0, "holds position"},
      {"rtl", {"rtl"}, 0, "returns to launch"},
      {"manual", {"manual", "--pitch", "0.1", "--for", "0.1"}, 0, "had the sticks"},
      {"goto", {"goto", "1", "0", "-2"}, 1, "home position"},
      {"doctor", {"doctor"}, 1, "gets no HIL_SENSOR"},
      {"monitor", {"monitor", "--once"}, 0, "HEARTBEAT"},
      {"watch", {"watch", "attitude", "--count", "2"}, 0, "roll 0.00 deg"},
      {"message", {"message", "HEARTBEAT"}, 0, "HEARTBEAT (0) from 1/1 on link fcu"},
      {"reboot", {"reboot"}, 0, "vehicle 1 accepted the restart"},
  };
  return list;
}

/// The verbs that `casctl --help` lists.
std::set<std::string> verbs_of_the_help() {
  ChildProcess casctl({cas::test::binary_dir() + "/bin/casctl", "--help"});
  casctl.wait_exit();
  std::istringstream lines(casctl.output());
  std::set<std::string> words;
  bool in_list = false;
  for (std::string line; std::getline(lines, line);) {
    if (line == "Subcommands:") {
      in_list = true;
    } else if (in_list && line.starts_with("  ") && line[2] != ' ') {
      words.insert(line.substr(2, line.find(' ', 2) - 2));
    } else {
      in_list = false;
    }
  }
  return words;
}

TEST(EveryVerb, IsInTheTable) {
  std::set<std::string> driven;
  for (const Verb& verb : verbs()) driven.insert(verb.arguments[0]);
  EXPECT_EQ(driven, verbs_of_the_help());
}

/// Verbs that look for a second or two; they get a test of their own, beside the others.
bool takes_its_time(const Verb& verb) {
  return verb.arguments[0] == "doctor" || verb.arguments[0] == "budget";
}

void drive(bool slow_ones) {
  EmulatorFixture fixture;
  fixture.start();
  ASSERT_TRUE(fixture.hears_the_vehicle()) << fixture.output();
  for (Verb verb : verbs()) {
    if (takes_its_time(verb) != slow_ones) continue;
    for (std::string& argument : verb.arguments) {
      if (argument[0] == '@') argument = (fixture.folder / argument.substr(1)).string();
    }
    const Ended said = fixture.casctl(verb.arguments);
    EXPECT_EQ(said.code, verb.code) << verb.name << ": " << said.output;
    EXPECT_NE(said.output.find(verb.says), std::string::npos) << verb.name << ": " << said.output;
  }
}

TEST(EveryVerb, WorksAgainstTheEmulatorOnTheGround) { drive(false); }

TEST(EveryVerb, ThatMeasuresWorksAgainstTheEmulatorToo) { drive(true); }

TEST(EveryVerb, DoctorFindsALineThatIsNotThere) {
  EmulatorFixture fixture;
  fixture.start_casd((fixture.folder / "nowhere").string(), 0);
  EXPECT_THAT(fixture.casctl({"doctor"}), EndedWith(1, "nowhere", "BAD"));
}

}  // namespace
}  // namespace cas::test
