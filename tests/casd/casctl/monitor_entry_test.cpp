// SPDX-License-Identifier: BSD-3-Clause
#include "casd/casctl/monitor/entry_line.hpp"

#include <gtest/gtest.h>

#include <string>

#include "casd/casctl/completion_words.hpp"
#include "casd/casctl/monitor/terminal.hpp"

namespace cas::casctl {
namespace {

class Entry : public testing::Test {
 protected:
  EntryLine::Result type(const std::string& text) {
    EntryLine::Result last;
    for (const char c : text) last = entry_.on_key(c, words_);
    return last;
  }
  EntryLine::Result press(int key) { return entry_.on_key(key, words_); }

  EntryLine entry_;
  PromptWords words_;
};

TEST_F(Entry, FiltersWithEachLetterAndShowsAllAfterEscape) {
  entry_.begin(EntryLine::Kind::kFilter, "HIL");
  EXPECT_EQ(type("_S").filter, "HIL_S");
  EXPECT_EQ(press(Terminal::kBackspace).filter, "HIL_");
  const auto left = press(Terminal::kEscape);
  EXPECT_EQ(left.filter, "");
  EXPECT_TRUE(left.ended);
  EXPECT_FALSE(entry_.is_open());
  entry_.begin(EntryLine::Kind::kFilter, "");
  type("GPS");
  const auto kept = press(Terminal::kEnter);
  EXPECT_EQ(kept.filter, "GPS");
  EXPECT_FALSE(kept.command.has_value());
}

TEST_F(Entry, EnterGivesTheCommandAndEscapeNone) {
  entry_.begin(EntryLine::Kind::kCommand, "");
  type("takeoff 3");
  EXPECT_EQ(entry_.text("vehicle 2 "), "vehicle 2 : takeoff 3");
  EXPECT_EQ(press(Terminal::kEnter).command, "takeoff 3");
  entry_.begin(EntryLine::Kind::kCommand, "");
  type("land");
  const auto left = press(Terminal::kEscape);
  EXPECT_TRUE(left.ended);
  EXPECT_FALSE(left.command.has_value());
  entry_.begin(EntryLine::Kind::kCommand, "");
  EXPECT_FALSE(press(Terminal::kEnter).command.has_value()) << "an empty line is none";
}

TEST_F(Entry, GainsOfALoopBecomeACommand) {
  entry_.begin_gains("roll", "6.5");
  EXPECT_EQ(entry_.text(""), "gains of roll (P I D): 6.5");
  press(Terminal::kBackspace);
  type("2");
  EXPECT_EQ(press(Terminal::kEnter).command, "setgain roll 6.2");
}

TEST_F(Entry, ArrowsGoThroughEarlierCommands) {
  entry_.remember("arm");
  entry_.remember("land");
  entry_.begin(EntryLine::Kind::kCommand, "");
  press(Terminal::kUp);
  press(Terminal::kUp);
  press(Terminal::kUp);  // there is none before the first
  EXPECT_EQ(entry_.text(""), ": arm");
  press(Terminal::kDown);
  EXPECT_EQ(entry_.text(""), ": land");
  press(Terminal::kDown);
  EXPECT_EQ(entry_.text(""), ": ");
}

TEST_F(Entry, TheFirstDigitReplacesTheGainsInForce) {
  entry_.begin_gains("position", "1.5");
  press(Terminal::kNone);  // nothing was pressed
  type("1.0");
  EXPECT_EQ(press(Terminal::kEnter).command, "setgain position 1.0");
  entry_.begin_gains("position", "1.5");
  press(Terminal::kBackspace);
  type("2");
  EXPECT_EQ(press(Terminal::kEnter).command, "setgain position 1.2") << "they were edited";
}

TEST_F(Entry, ControlUClearsTheLine) {
  entry_.begin(EntryLine::Kind::kCommand, "takeoff 3");
  press(Terminal::kClear);
  type("land");
  EXPECT_EQ(press(Terminal::kEnter).command, "land");
}

TEST_F(Entry, TabCompletesAndTellsWhenParametersAreWanted) {
  words_.by_verb = completion_words();
  entry_.begin(EntryLine::Kind::kCommand, "");
  type("tak");
  EXPECT_FALSE(press(Terminal::kTab).wants_parameters);
  EXPECT_EQ(entry_.text("").substr(0, 9), ": takeoff");
  entry_.begin(EntryLine::Kind::kCommand, "param get MC_");
  EXPECT_TRUE(press(Terminal::kTab).wants_parameters);
  EXPECT_NE(entry_.hint(words_, true, 80).find("asking for"), std::string::npos);
  EXPECT_NE(entry_.hint(words_, false, 80).find("Tab asks"), std::string::npos);
}

TEST_F(Entry, AHintFitsTheScreen) {
  entry_.begin(EntryLine::Kind::kCommand, "");
  const std::string hint = entry_.hint(words_, false, 40);
  EXPECT_LE(hint.size(), 40U) << hint;
  EXPECT_NE(hint.find(" more"), std::string::npos) << hint;
}

}  // namespace
}  // namespace cas::casctl
