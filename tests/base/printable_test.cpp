// SPDX-License-Identifier: BSD-3-Clause
#include "base/printable.hpp"

#include <gtest/gtest.h>

namespace cas::base {
namespace {

TEST(Printable, LeavesTextsOfAnyLanguage) {
  for (const char* text : {"", "hover 2.5 m", "a\tb", "Höhe 3 m", "高度", "\xE2\x82\xAC 5",
                           "\xFF\xFE", "\xC2", "\xE2\x80"}) {
    EXPECT_EQ(printable(text), text);
  }
}

TEST(Printable, GivesNoTerminalOrders) {
  EXPECT_EQ(printable("\x1b]0;pwn\x07"), "?]0;pwn?");
  EXPECT_EQ(printable("a\nb\rc\x7F"), "a?b?c?");
  EXPECT_EQ(printable("\xC2\x9B"
                      "31mred"),
            "?31mred");
}

TEST(Printable, TurnsNoTextRound) {
  EXPECT_EQ(printable("\xE2\x80\xAEgnp.exe"), "?gnp.exe");
  EXPECT_EQ(printable("a\xE2\x81\xA6z\xE2\x81\xA9"), "a?z?");
  EXPECT_EQ(printable("\xE2\x80\x8B|\xD8\x9C|\xEF\xBB\xBF"), "?|?|?");
}

TEST(Printable, HidesNoTextInAnother) {
  EXPECT_EQ(printable("a\xC2\xADz|\xE1\xA0\x8E"), "a?z|?") << "soft hyphen, vowel separator";
  EXPECT_EQ(printable("\xF3\xA0\x80\x81|\xF3\xA0\x81\xBF"), "?|?") << "tags";
  EXPECT_EQ(printable("\xC2\xAE|\xE1\xA0\x8F|\xF3\xA0\x82\x80|\xF0\x9F\x9A\x81"),
            "\xC2\xAE|\xE1\xA0\x8F|\xF3\xA0\x82\x80|\xF0\x9F\x9A\x81")
      << "their neighbours, and a helicopter";
}

TEST(PrintableLines, EndWhereTheyDid) {
  EXPECT_EQ(printable_lines("one\x1b[31m\n\ttwo\r\n\n"), "one?[31m\n\ttwo?\n\n");
  EXPECT_EQ(printable_lines(""), "");
}

}  // namespace
}  // namespace cas::base
