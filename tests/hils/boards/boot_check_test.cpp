// SPDX-License-Identifier: BSD-3-Clause
#include "hils/boards/boot_check.hpp"

#include <gtest/gtest.h>

namespace cas::hils {
namespace {

const Board kBootBoard{.name = "a", .serial = "7", .firmware = "1.15", .commit = "12ab"};

BoardFacts booted() {
  return {.device = "/dev/ttyACM0",
          .link_up = true,
          .heard = true,
          .hil = true,
          .autopilot = "PX4",
          .firmware = "1.15.2",
          .commit = "12ab34cd00000000"};
}

struct BootCase {
  const char* name;
  BoardFacts facts;
  ExitCode code;
  const char* sentence;
};

BootCase differing(const char* name, void (*change)(BoardFacts&), ExitCode code,
                   const char* sentence) {
  BootCase boot{name, booted(), code, sentence};
  change(boot.facts);
  return boot;
}

class Boot : public testing::TestWithParam<BootCase> {};

TEST_P(Boot, HasACodeAndASentence) {
  const BootVerdict verdict = judge_boot(GetParam().facts, kBootBoard);
  EXPECT_EQ(verdict.code, GetParam().code);
  EXPECT_EQ(verdict.sentence, GetParam().sentence);
}

INSTANTIATE_TEST_SUITE_P(
    All, Boot,
    testing::Values(
        differing(
            "Good", [](BoardFacts&) {}, kExitPassed,
            "board 'a' has booted: PX4 1.15.2 (12ab34cd00000000), in HIL, disarmed"),
        differing(
            "Absent", [](BoardFacts& facts) { facts = {}; }, kExitBoardAbsent,
            "board 'a' is not there: no serial port of a USB device with the serial number 7"),
        differing(
            "NotOurs",
            [](BoardFacts& facts) {
              facts.link_up = false;
              facts.link_words = "Permission denied";
            },
            kExitBoardAbsent, "board 'a': /dev/ttyACM0 cannot be opened: Permission denied"),
        differing(
            "Silent", [](BoardFacts& facts) { facts.heard = false; }, kExitNoBoot,
            "board 'a' does not boot: no HEARTBEAT comes from /dev/ttyACM0"),
        differing(
            "NoVersion", [](BoardFacts& facts) { facts.firmware.clear(); }, kExitNoBoot,
            "board 'a' does not say its version: no AUTOPILOT_VERSION comes from /dev/ttyACM0"),
        differing(
            "OtherVersion", [](BoardFacts& facts) { facts.firmware = "1.14.0"; }, kExitNoBoot,
            "board 'a' runs firmware 1.14.0 instead of 1.15"),
        differing(
            "OtherCommit", [](BoardFacts& facts) { facts.commit = "99"; }, kExitNoBoot,
            "board 'a' runs firmware of commit 99 instead of 12ab"),
        differing(
            "UnknownCommit", [](BoardFacts& facts) { facts.commit.clear(); }, kExitNoBoot,
            "board 'a' runs firmware of commit unknown instead of 12ab")),
    [](const auto& test) { return test.param.name; });

TEST(Boot, OfABoardOfWhichNothingIsExpectedNeedsNoVersion) {
  BoardFacts facts = booted();
  facts.firmware.clear();
  facts.commit.clear();
  facts.armed = true;
  EXPECT_FALSE(has_booted(facts)) << "it may still say it";
  const BootVerdict verdict = judge_boot(facts, {.name = "a", .device = "/dev/x"});
  EXPECT_EQ(verdict.code, kExitPassed);
  EXPECT_EQ(verdict.sentence, "board 'a' has booted: PX4 of an unknown version, in HIL, armed");
}

TEST(Boot, VersionsAreComparedNumberByNumber) {
  EXPECT_TRUE(is_version("1.15.0", "1.15.0"));
  EXPECT_TRUE(is_version("1.15.0", "1"));
  EXPECT_FALSE(is_version("1.15.0", "1.1"));
  EXPECT_FALSE(is_version("1.15", "1.15.0"));
}

TEST(Boot, CommitsAreComparedAsFarAsBothGo) {
  EXPECT_TRUE(is_commit("12ab34cd00112233", "12ab34cd0011223344556677889900aabbccddee"));
  EXPECT_TRUE(is_commit("12ab34cd", "12ab"));
  EXPECT_FALSE(is_commit("12ab34cd00112233", "12ab34ce0011223344556677889900aabbccddee"));
  EXPECT_FALSE(is_commit("12ab", "12ab34cd")) << "too short to tell";
  EXPECT_FALSE(is_commit("", "12ab"));
}

TEST(Boot, ReadsTheCommitAsEachAutopilotWritesIt) {
  constexpr std::array<std::uint8_t, 8> kPx4{0, 0, 0, 0, 0xcd, 0x34, 0xab, 0x12};
  EXPECT_EQ(commit_text(kPx4, "PX4"), "12ab34cd00000000");
  constexpr std::array<std::uint8_t, 8> kArdupilot{'1', '2', 'a', 'B', '3', '4', 'c', 'd'};
  EXPECT_EQ(commit_text(kArdupilot, "ArduPilot"), "12ab34cd");
  EXPECT_EQ(commit_text({}, "PX4"), "");
}

}  // namespace
}  // namespace cas::hils
