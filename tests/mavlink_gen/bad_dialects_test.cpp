// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <ostream>
#include <string>

#include "mavlink_gen/parser/dialect_loader.hpp"
#include "tests/support/temporary_folder.hpp"

namespace {

using namespace cas::mav::xml;
using cas::test::TemporaryFolder;

/// A dialect with one fault. '@' in the text marks the place that the
/// diagnostic must name.
struct BadDialect {
  const char* name;
  std::string text;
  const char* sentence;  // part of it
  Severity severity{Severity::kError};
};

std::string in_mavlink(const std::string& body) { return "<mavlink>\n" + body + "\n</mavlink>\n"; }

std::string in_enum(const std::string& entries, const std::string& fields = "") {
  std::string body = "<enums>\n <enum name=\"E\">\n  " + entries + "\n </enum>\n</enums>";
  if (!fields.empty()) {
    body += "\n<messages>\n <message id=\"1\" name=\"M\">\n" + fields + "</message></messages>";
  }
  return in_mavlink(body);
}

std::string in_message(const std::string& fields) {
  return in_mavlink("<messages>\n <message id=\"1\" name=\"M\">\n  " + fields +
                    "\n </message>\n</messages>");
}

std::string in_messages(const std::string& messages) {
  return in_mavlink("<messages>\n " + messages + "\n</messages>");
}

const std::string kField = "<field type=\"uint8_t\" name=\"a\"/>";

std::string fields(int count, const std::string& type) {
  std::string out;
  for (int i = 0; i < count; ++i) {
    out += "<field type=\"" + type + "\" name=\"f" + std::to_string(i) + "\"/>\n";
  }
  return out;
}

/// The place of the marker, which is taken out of the text.
Position take_marker(std::string& text) {
  const auto at = text.find('@');
  EXPECT_NE(at, std::string::npos);
  text.erase(at, 1);
  const auto before = text.substr(0, at);
  const auto line = 1 + std::count(before.begin(), before.end(), '\n');
  const auto last_end = before.rfind('\n');
  std::size_t column = 1;
  for (auto i = last_end == std::string::npos ? 0 : last_end + 1; i < at; ++i) {
    column += (static_cast<unsigned char>(text[i]) & 0xC0U) != 0x80U;
  }
  return {0, static_cast<std::uint32_t>(line), static_cast<std::uint32_t>(column)};
}

TEST(BadDialects, AreReportedAtTheirPlace) {
  const BadDialect rows[] = {
      {"Empty", "@", "not well formed"},
      {"NoXml", "@hello", "not well formed"},
      {"WrongRoot", "@<html/>", "the root element is <html>"},
      {"Unclosed", "<mavlink>\n<enums>\n</@mavlink>", "not well formed"},
      {"Doctype", "<!DOCTYPE mavlink @[<!ENTITY a \"b\">]>\n<mavlink/>",
       "document type declaration"},
      {"AttributeTwice", "<mavlink><enums a=\"1\" @a=\"2\"/></mavlink>", "not well formed"},
      {"TooDeep",
       [] {
         std::string text = "<mavlink>";
         for (int i = 0; i < 31; ++i) text += "<x>";
         return text + "@<x></x>";
       }(),
       "nested too deeply"},
      {"UnknownElement", in_mavlink("  @<mesages/>"), "did you mean messages?"},
      {"MessageInEnums", in_mavlink("<enums>\n@<message/></enums>"),
       "<message> is not allowed in <enums>"},
      {"VersionIsNoNumber", in_mavlink("<version> @three</version>"), "'three', not a number"},
      {"VersionTwice", in_mavlink("<version>3</version>\n@<version>3</version>"), "stands twice"},
      {"IncludeOfNothing", in_mavlink(" @<include> </include>"), "names no file"},
      {"IncludeMissing", in_mavlink(" @<include>none.xml</include>"), "there is no such file"},
      {"IncludeOfAFolder", in_mavlink(" @<include>.</include>"), "no regular file"},
      {"IncludeOfItself", in_mavlink(" @<include>bad.xml</include>"), "bad.xml -> bad.xml"},
      {"UnknownAttribute", in_mavlink("<enums><enum name=\"E\" @bitmsk=\"true\"/></enums>"),
       "did you mean bitmask?", Severity::kWarning},
      {"FlagIsNoFlag", in_mavlink("<enums><enum name=\"E\" @bitmask=\"yes\"/></enums>"),
       "neither true nor false", Severity::kWarning},
      {"EnumWithoutName", in_mavlink("<enums>@<enum/></enums>"), "lacks the attribute"},
      {"EnumNameIsNoName", in_mavlink("<enums><enum @name=\"A B\"/></enums>"), "is no name"},
      {"EnumNameOfCode", in_mavlink("<enums><enum @name=\"A{};int main()\"/></enums>"),
       "is no name"},
      {"EntryWithoutName", in_enum("@<entry value=\"1\"/>"), "lacks the attribute 'name'"},
      {"ValueIsNoNumber", in_enum("<entry @value=\"one\" name=\"A\"/>"), "no enum value"},
      {"ValueIsCode", in_enum("<entry @value=\"__import__('os')\" name=\"A\"/>"), "no enum value"},
      {"ValueIsASum", in_enum("<entry @value=\"1+1\" name=\"A\"/>"), "no enum value"},
      {"ValueIsEmpty", in_enum("<entry @value=\"\" name=\"A\"/>"), "no enum value"},
      {"ValueIsAHugePower", in_enum("<entry @value=\"2**999999999\" name=\"A\"/>"),
       "no enum value"},
      {"ValueIsAPowerOfThree", in_enum("<entry @value=\"3**2\" name=\"A\"/>"), "no enum value"},
      {"ValueIsTooLarge", in_enum("<entry @value=\"18446744073709551616\" name=\"A\"/>"),
       "no enum value"},
      {"ValueIsTooSmall", in_enum("<entry @value=\"-9223372036854775809\" name=\"A\"/>"),
       "no enum value"},
      {"HexWithoutDigits", in_enum("<entry @value=\"0x\" name=\"A\"/>"), "no enum value"},
      {"BinaryWithATwo", in_enum("<entry @value=\"0b12\" name=\"A\"/>"), "no enum value"},
      {"NoValueAboveTheHighest",
       in_enum("<entry value=\"0xFFFFFFFFFFFFFFFF\" name=\"A\"/>@<entry name=\"B\"/>"),
       "none is left"},
      {"NameTwice", in_enum("<entry value=\"1\" name=\"A\"/>\n  @<entry value=\"2\" name=\"A\"/>"),
       "the entry A is already at"},
      {"ValueTwice",
       in_enum("<entry value=\"1\" name=\"A\"/>\n  @<entry value=\"0x1\" name=\"B\"/>"),
       "the value 1 of E is already that of A"},
      {"NoTypeHoldsAll",
       in_mavlink("<enums>@<enum name=\"E\"><entry value=\"-1\" name=\"A\"/>"
                  "<entry value=\"2**63\" name=\"B\"/></enum></enums>"),
       "no 64-bit type"},
      {"ParamWithoutIndex", in_enum("<entry value=\"1\" name=\"A\">@<param/></entry>"),
       "lacks the attribute 'index'"},
      {"ParamEight", in_enum("<entry value=\"1\" name=\"A\"><param @index=\"8\"/></entry>"),
       "no parameter index"},
      {"ParamZero", in_enum("<entry value=\"1\" name=\"A\"><param @index=\"0\"/></entry>"),
       "no parameter index"},
      {"ParamTwice",
       in_enum("<entry value=\"1\" name=\"A\"><param index=\"1\"/><param @index=\"1\"/></entry>"),
       "parameter 1 stands twice"},
      {"ColumnsCountCharacters",
       in_mavlink("<enums><enum name=\"E\"><description>\xC3\xA4\xE2\x82\xAC"
                  "</description><entry @value=\"x\" name=\"A\"/></enum></enums>"),
       "no enum value"},
      {"NoId", in_messages("@<message name=\"M\">" + kField + "</message>"),
       "lacks the attribute 'id'"},
      {"NoName", in_messages("@<message id=\"1\">" + kField + "</message>"),
       "lacks the attribute 'name'"},
      {"IdTooLarge", in_messages("<message @id=\"16777216\" name=\"M\">" + kField + "</message>"),
       "no message id"},
      {"IdNegative", in_messages("<message @id=\"-1\" name=\"M\">" + kField + "</message>"),
       "no message id"},
      {"IdHex", in_messages("<message @id=\"0x10\" name=\"M\">" + kField + "</message>"),
       "no message id"},
      {"IdTwice",
       in_messages("<message id=\"1\" name=\"A\">" + kField +
                   "</message>\n@<message id=\"1\" name=\"B\">" + kField + "</message>"),
       "id 1 is already that of the message at"},
      {"MessageTwice",
       in_messages("<message id=\"1\" name=\"A\">" + kField +
                   "</message>\n@<message id=\"2\" name=\"A\">" + kField + "</message>"),
       "message A is already at"},
      {"NoFields", in_messages("@<message id=\"1\" name=\"M\"/>"), "no base field"},
      {"ExtensionsOnly",
       in_messages("@<message id=\"1\" name=\"M\"><extensions/>" + kField + "</message>"),
       "no base field"},
      {"ExtensionsTwice", in_message(kField + "<extensions/>@<extensions/>"), "stands twice"},
      {"FieldWithoutType", in_message("@<field name=\"a\"/>"), "lacks the attribute 'type'"},
      {"FieldWithoutName", in_message("@<field type=\"uint8_t\"/>"), "lacks the attribute 'name'"},
      {"FieldNameWithADash", in_message("<field type=\"uint8_t\" @name=\"a-b\"/>"), "is no name"},
      {"FieldNameWithADigitFirst", in_message("<field type=\"uint8_t\" @name=\"1a\"/>"),
       "is no name"},
      {"FieldTwice", in_message(kField + "<field type=\"float\" @name=\"a\"/>"),
       "has the field a twice"},
      {"MisspeltType", in_message("<field @type=\"unit8_t\" name=\"a\"/>"),
       "unknown type 'unit8_t'; did you mean uint8_t?"},
      {"TypeOfNothing", in_message("<field @type=\"\" name=\"a\"/>"), "unknown type ''"},
      {"ArrayOfZero", in_message("<field @type=\"uint8_t[0]\" name=\"a\"/>"), "no array length"},
      {"ArrayOf256", in_message("<field @type=\"uint8_t[256]\" name=\"a\"/>"), "no array length"},
      {"ArrayNotClosed", in_message("<field @type=\"uint8_t[4\" name=\"a\"/>"), "no array length"},
      {"ArrayOfNothing", in_message("<field @type=\"uint8_t[]\" name=\"a\"/>"), "no array length"},
      {"ArrayOfArrays", in_message("<field @type=\"uint8_t[2][2]\" name=\"a\"/>"),
       "no array length"},
      {"OldArrayWithoutLength", in_message("<field @type=\"array\" name=\"a\"/>"),
       "unknown type 'array'"},
      {"VersionInARow", in_message("<field @type=\"uint8_t_mavlink_version[2]\" name=\"a\"/>"),
       "unknown type"},
      {"TooLarge",
       in_messages("@<message id=\"1\" name=\"M\">" + fields(32, "uint64_t") + "</message>"),
       "needs 256 bytes"},
      {"TooManyFields",
       in_message(fields(64, "uint8_t") + "@<field type=\"uint8_t\" name=\"last\"/>"),
       "more than 64 fields"},
      {"ElementInAField", in_message("<field type=\"uint8_t\" name=\"a\">@<b/></field>"),
       "<b> is not allowed in <field>"},
      {"FieldInWrongPlace", in_messages("@" + kField), "not allowed in <messages>"},
      {"UnknownEnum", in_message("@<field type=\"uint8_t\" name=\"a\" enum=\"NONE\"/>"),
       "there is no enum NONE", Severity::kWarning},
      {"HighestValueDoesNotFit",
       in_enum("<entry value=\"131072\" name=\"A\"/>",
               "@<field type=\"uint16_t\" name=\"a\" enum=\"E\"/>"),
       "a is uint16_t, but the highest value of E is 131072: it stays a number",
       Severity::kWarning},
      {"LowestValueDoesNotFit",
       in_enum("<entry value=\"-1\" name=\"A\"/>",
               "@<field type=\"uint8_t\" name=\"a\" enum=\"E\"/>"),
       "a is uint8_t, but the lowest value of E is -1: it stays a number", Severity::kWarning},
      {"ValueNeedsTheSignsBit",
       in_enum("<entry value=\"128\" name=\"A\"/>",
               "@<field type=\"int8_t\" name=\"a\" enum=\"E\"/>"),
       "a is int8_t, but the highest value of E is 128", Severity::kWarning},
      {"NoTypeHoldsBothFields",
       in_enum("<entry value=\"1\" name=\"A\"/>",
               "<field type=\"uint64_t\" name=\"a\" enum=\"E\"/>\n"
               "@<field type=\"int8_t\" name=\"b\" enum=\"E\"/>"),
       "b is int8_t, but E is in fields of uint64_t as well: it stays a number",
       Severity::kWarning},
      {"VersionFieldWithoutVersion",
       in_message("@<field type=\"uint8_t_mavlink_version\" name=\"a\"/>"),
       "the file has no <version>", Severity::kWarning}};
  for (const auto& row : rows) {
    SCOPED_TRACE(row.name);
    auto [name, text, sentence, severity] = row;
    const auto place = take_marker(text);
    const TemporaryFolder folder;
    const auto file = folder.write("bad.xml", text);
    Diagnostics diagnostics;
    const auto dialect = load_dialect(file, diagnostics);
    EXPECT_EQ(dialect.has_value(), severity == Severity::kWarning);
    ASSERT_EQ(diagnostics.all().size(), 1U) << diagnostics.render();
    const auto& diagnostic = diagnostics.all().front();
    EXPECT_EQ(diagnostic.severity, severity);
    EXPECT_NE(diagnostic.text.find(sentence), std::string::npos) << diagnostic.text;
    EXPECT_EQ(diagnostic.position.line, place.line) << diagnostics.render();
    EXPECT_EQ(diagnostic.position.column, place.column) << diagnostics.render();
  }
}

TEST(Diagnostics, SeveralErrorsComeInOneRun) {
  const TemporaryFolder folder;
  const auto file =
      folder.write("bad.xml", in_message("<field type=\"unit8_t\" name=\"a\"/>\n"
                                         "<field type=\"uint8_t\" name=\"b c\"/>\n<feild/>"));
  Diagnostics diagnostics;
  EXPECT_FALSE(load_dialect(file, diagnostics));
  EXPECT_EQ(diagnostics.error_count(), 3U);
}

TEST(Diagnostics, ChainOfIncludesLeadsToTheFault) {
  const TemporaryFolder folder;
  folder.write("sub/inner.xml", in_message("<field type=\"floot\" name=\"a\"/>"));
  folder.write("middle.xml", in_mavlink("<include>sub/inner.xml</include>"));
  const auto file = folder.write("outer.xml", in_mavlink("\n<include>middle.xml</include>"));
  Diagnostics diagnostics;
  EXPECT_FALSE(load_dialect(file, diagnostics));
  const auto root = folder.path().string();
  EXPECT_EQ(diagnostics.render(),
            "in file included from " + root + "/middle.xml:2:1\n" +  //
                "                 from " + root + "/outer.xml:3:1\n" + root +
                "/sub/inner.xml:4:10: error: unknown type 'floot'; did you mean float?\n");
}

TEST(Diagnostics, CircleOfIncludesIsNamed) {
  const TemporaryFolder folder;
  folder.write("b.xml", in_mavlink("<include>c.xml</include>"));
  folder.write("c.xml", in_mavlink("<include>a.xml</include>"));
  const auto file = folder.write("a.xml", in_mavlink("<include>b.xml</include>"));
  Diagnostics diagnostics;
  EXPECT_FALSE(load_dialect(file, diagnostics));
  ASSERT_EQ(diagnostics.error_count(), 1U);
  EXPECT_NE(diagnostics.all()[0].text.find("a.xml -> b.xml -> c.xml -> a.xml"), std::string::npos);
}

std::string many_messages(int count) {
  std::string messages;
  for (int i = 0; i < count; ++i) {
    const std::string number = std::to_string(i);
    messages += "<message id=\"" + number + "\" name=\"M" + number +
                "\"><field type=\"uint8_t\" name=\"f\"/></message>";
  }
  return in_mavlink("<messages>" + messages + "</messages>");
}

TEST(Diagnostics, ADialectHasABoundedNumberOfMessages) {
  const TemporaryFolder folder;
  Diagnostics allowed;
  EXPECT_TRUE(load_dialect(folder.write("allowed.xml", many_messages(10'000)), allowed));
  Diagnostics more;
  EXPECT_FALSE(load_dialect(folder.write("more.xml", many_messages(10'001)), more));
  EXPECT_NE(more.render().find("more than 10000 messages"), std::string::npos);
}

TEST(Diagnostics, ADialectHasABoundedNumberOfElements) {
  const TemporaryFolder folder;
  Diagnostics diagnostics;
  EXPECT_FALSE(load_dialect(folder.write("more.xml", many_messages(60'000)), diagnostics));
  EXPECT_NE(diagnostics.render().find("more than 100000 elements"), std::string::npos);
  EXPECT_EQ(diagnostics.error_count(), 1U);  // it is refused where the bound is crossed
}

TEST(Diagnostics, ManyErrorsAreCountedNotKept) {
  const TemporaryFolder folder;
  std::string body;
  for (int i = 0; i < 5000; ++i) body += "<feild/>";
  Diagnostics diagnostics;
  EXPECT_FALSE(load_dialect(folder.write("bad.xml", in_message(kField + body)), diagnostics));
  EXPECT_EQ(diagnostics.error_count(), 5000U);
  EXPECT_EQ(diagnostics.all().size(), Diagnostics::kMaxKept);
  EXPECT_NE(diagnostics.render().find("4900 more errors"), std::string::npos);
}

TEST(Diagnostics, SuggestionsEndWithTheDiagnosticsThatAreKept) {
  const TemporaryFolder folder;
  std::string misspelt;
  for (int i = 0; i < 150; ++i) {
    const std::string number = std::to_string(i);
    misspelt += "<message id=\"" + number + "\" name=\"M" + number +
                "\"><field type=\"uint8_t\" name=\"a\" enum=\"COLOUR_KINT\"/></message>\n";
  }
  const auto file =
      folder.write("bad.xml", in_mavlink("<enums><enum name=\"COLOUR_KIND\"/></enums>\n<messages>" +
                                         misspelt + "</messages>"));
  Diagnostics diagnostics;
  EXPECT_TRUE(load_dialect(file, diagnostics));
  EXPECT_EQ(diagnostics.warning_count(), 150U);
  ASSERT_EQ(diagnostics.all().size(), Diagnostics::kMaxKept);
  EXPECT_NE(diagnostics.all().back().text.find("did you mean COLOUR_KIND?"), std::string::npos);
  EXPECT_NE(diagnostics.render().find("50 more warnings are not shown"), std::string::npos);
  EXPECT_EQ(diagnostics.suggest(Severity::kWarning, "COLOUR_KINT", {"COLOUR_KIND"}), "");
  EXPECT_NE(diagnostics.suggest(Severity::kError, "COLOUR_KINT", {"COLOUR_KIND"}), "");
}

TEST(Diagnostics, MissingFileIsAnError) {
  Diagnostics diagnostics;
  EXPECT_FALSE(load_dialect("/nowhere/at/all.xml", diagnostics));
  EXPECT_EQ(diagnostics.error_count(), 1U);
}

}  // namespace
