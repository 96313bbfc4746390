// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <sys/stat.h>
#include <sys/wait.h>

#include <cstdio>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <ostream>
#include <string>

#include "mavlink_gen/generator/diff.hpp"
#include "mavlink_gen/generator/naming.hpp"
#include "mavlink_gen/generator/output_files.hpp"
#include "mavlink_gen/generator/subset.hpp"
#include "mavlink_gen/generator/writers.hpp"
#include "mavlink_gen/parser/dialect_loader.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/temporary_folder.hpp"

namespace {

using namespace cas::mav;
using cas::test::TemporaryFolder;
using testing::HasSubstr;
using testing::Not;

const std::string kDialects = cas::test::source_dir() + "/tests/mavlink_gen/dialects/";
const std::string kCommon = cas::test::source_dir() + "/mavlink_gen/dialects/common.xml";

xml::Dialect load(const std::string& file) {
  xml::Diagnostics diagnostics;
  auto dialect = xml::load_dialect(file, diagnostics);
  EXPECT_EQ(diagnostics.error_count(), 0U) << diagnostics.render();
  return dialect.value_or(xml::Dialect{});
}

struct Outcome {
  int code{};
  std::string output;  // of both streams
};

Outcome shell(const std::string& command) {
  Outcome outcome;
  auto* pipe = ::popen(command.c_str(), "r");
  char buffer[4096];
  for (std::size_t n; (n = std::fread(buffer, 1, sizeof buffer, pipe)) > 0;) {
    outcome.output.append(buffer, n);
  }
  outcome.code = WEXITSTATUS(::pclose(pipe));
  return outcome;
}

Outcome run(const std::string& arguments) {
  return shell(cas::test::binary_dir() + "/bin/mavlink_gen " + arguments + " 2>&1");
}

struct NameCase {
  const char* enum_name;
  const char* entry;
  const char* enumerator;
};

TEST(Naming, EntriesLoseTheWordsTheyShareWithTheirEnum) {
  for (const auto& [enum_name, entry, enumerator] : {
           NameCase{"MAV_CMD", "MAV_CMD_NAV_TAKEOFF", "kNavTakeoff"},
           NameCase{"MAV_COMPONENT", "MAV_COMP_ID_AUTOPILOT1", "kCompIdAutopilot1"},
           NameCase{"HIL_SENSOR_UPDATED_FLAGS", "HIL_SENSOR_UPDATED_XACC", "kXacc"},
           NameCase{"GPS_FIX_TYPE", "GPS_FIX_TYPE_3D_FIX", "k3dFix"},
           NameCase{"A", "A", "kA"},
           NameCase{"A_B", "A_B", "kB"},
           NameCase{"A", "A_1_2", "k1_2"},
       }) {
    xml::Enum item;
    item.name = enum_name;
    item.entries.resize(1);
    item.entries[0].name = entry;
    EXPECT_EQ(gen::Names::enumerators(item).front(), enumerator) << entry;
  }
}

TEST(Naming, PascalCaseKeepsDigitsApart) {
  EXPECT_EQ(gen::pascal_case("HIL_SENSOR"), "HilSensor");
  EXPECT_EQ(gen::pascal_case("GPS2_RAW"), "Gps2Raw");
  EXPECT_EQ(gen::pascal_case("PART_1_2"), "Part1_2");
}

TEST(OutputFiles, UnchangedFilesAreNotTouched) {
  const TemporaryFolder folder;
  const gen::Files files{{"a/b.hpp", "text"}};
  ASSERT_EQ(gen::write_files(folder.path(), files), std::nullopt);
  const auto time_of = [&] {
    struct stat status {};
    ::stat((folder.path() / "a/b.hpp").c_str(), &status);
    return std::pair(status.st_ino, status.st_mtim.tv_nsec);
  };
  const auto before = time_of();
  ASSERT_EQ(gen::write_files(folder.path(), files), std::nullopt);
  EXPECT_EQ(time_of(), before);
  ASSERT_EQ(gen::write_files(folder.path(), {{"a/b.hpp", "other"}}), std::nullopt);
  EXPECT_EQ(TemporaryFolder::read(folder.path() / "a/b.hpp"), "other");
}

TEST(OutputFiles, FolderThatCannotBeMadeIsASentence) {
  EXPECT_NE(gen::write_files("/proc/no/such", {{"a", "b"}}), std::nullopt);
}

TEST(CppWriter, SameInputGivesTheSameBytes) {
  EXPECT_EQ(gen::write_cpp(load(kCommon), "common"), gen::write_cpp(load(kCommon), "common"));
}

TEST(Subset, KeepsTheMessagesNamedAndWhatTheyUse) {
  auto dialect = load(kCommon);
  ASSERT_EQ(gen::keep_only(dialect, {"HEARTBEAT", "COMMAND_LONG"}), std::nullopt);
  EXPECT_EQ(dialect.messages.size(), 2U);
  EXPECT_NE(dialect.find_enum("MAV_TYPE"), nullptr);
  EXPECT_NE(dialect.find_enum("MAV_CMD"), nullptr);
  EXPECT_NE(dialect.find_enum("MAV_VTOL_STATE"), nullptr) << "a parameter of a command uses it";
  EXPECT_EQ(dialect.find_enum("MAV_SEVERITY"), nullptr);
  EXPECT_THAT(gen::keep_only(dialect, {"HEARTBEET"}),
              testing::Optional(testing::HasSubstr("did you mean HEARTBEAT?")));
}

TEST(Json, HoldsEveryFactOfTheDialect) {
  const auto json = nlohmann::json::parse(gen::write_json(load(kDialects + "every_construct.xml")));
  EXPECT_EQ(json["schema"], 1);
  EXPECT_EQ(json["dialect"], "every_construct");
  EXPECT_EQ(json["version"], 9);
  const auto& last = json["messages"].back();
  EXPECT_EQ(last["id"], 16777215);
  EXPECT_EQ(last["fields"].size(), 23U);
  EXPECT_EQ(last["fields"][3]["units"], "cm/s");
}

TEST(Docs, ShowFieldsEnumsAndParameters) {
  const auto page = gen::write_docs(load(kDialects + "every_construct.xml"));
  EXPECT_THAT(page, HasSubstr("CRANE\\_STATUS (201)"));
  EXPECT_THAT(page, HasSubstr("Deprecated since 2026-01, use ALL\\_TYPES."));
  EXPECT_THAT(page, HasSubstr("1: Mass (kg)"));
  EXPECT_THAT(page, Not(HasSubstr("<markup>"))) << "text must not become HTML";
}

// --- diff
// ----------------------------------------------------------------------------------------

struct ChangeCase {
  const char* name;
  const char* from;  // replaced in the dialect below
  const char* to;
  gen::Impact impact;
  const char* text;
};

const std::string kBefore = R"(<mavlink><enums><enum name="E">
<entry value="1" name="E_ONE"/><entry value="2" name="E_TWO"/></enum></enums>
<messages><message id="7" name="M"><field type="uint16_t" name="a" units="m"/>
<field type="uint8_t" name="b" enum="E"/><extensions/><field type="uint8_t" name="x"/>
</message></messages></mavlink>)";

using gen::Impact;
TEST(Diff, SaysWhatAChangeDoes) {
  const ChangeCase rows[] = {
      {"IdChanged", "id=\"7\"", "id=\"8\"", Impact::kBreaks, "id 7 became 8"},
      {"MessageRenamed", "name=\"M\"", "name=\"N\"", Impact::kBreaks, "M: removed"},
      {"TypeChanged", "uint16_t", "int16_t", Impact::kBreaks, "was uint16_t, is int16_t"},
      {"FieldRenamed", "name=\"a\"", "name=\"c\"", Impact::kBreaks, "field a removed"},
      {"FieldAdded", "<extensions/>", "<field type=\"float\" name=\"n\"/><extensions/>",
       Impact::kBreaks, "field n added"},
      {"ExtensionInFront", "<extensions/>", "<extensions/><field type=\"float\" name=\"n\"/>",
       Impact::kBreaks, "moved from byte 3 to 7"},
      {"ExtensionBecomesBase", "<extensions/>", "", Impact::kBreaks, "is no extension any more"},
      {"ExtensionAtTheEnd", "\n</message>", "<field type=\"float\" name=\"n\"/></message>",
       Impact::kCompatible, "extension n added"},
      {"UnitChanged", "units=\"m\"", "units=\"mm\"", Impact::kMeaning,
       "unit of a was 'm', is 'mm'"},
      {"ValueChanged", "value=\"2\"", "value=\"3\"", Impact::kMeaning, "E_TWO was 2, is 3"},
      {"EntryRenamed", "E_TWO", "E_ZWEI", Impact::kSource, "renamed to E_ZWEI"},
      {"EntryRemoved", "<entry value=\"2\" name=\"E_TWO\"/>", "", Impact::kSource, "E_TWO removed"},
      {"EntryAdded", "</enum>", "<entry value=\"9\" name=\"E_NINE\"/></enum>", Impact::kCompatible,
       "E_NINE added"},
      {"EnumWidened", "</enum>", "<entry value=\"300\" name=\"E_BIG\"/></enum>", Impact::kSource,
       "E: was std::uint8_t, is std::uint16_t"},
      {"MemberTakesAnEnum", "name=\"a\"", "name=\"a\" enum=\"E\"", Impact::kMeaning,
       "member a became an enum"},
      {"MessageAdded", "</messages>",
       "<message id=\"8\" name=\"N\"><field type=\"char\" name=\"a\"/></message></messages>",
       Impact::kCompatible, "N: added"}};
  for (const auto& [name, from, to, impact, text] : rows) {
    SCOPED_TRACE(name);
    auto changed = kBefore;
    const auto at = changed.find(from);
    ASSERT_NE(at, std::string::npos);
    changed.replace(at, std::string(from).size(), to);
    const TemporaryFolder folder;
    const auto changes = gen::compare(load(folder.write("a.xml", kBefore).string()),
                                      load(folder.write("b.xml", changed).string()));
    ASSERT_FALSE(changes.empty());
    EXPECT_EQ(changes.front().impact, impact) << gen::render(changes);
    EXPECT_THAT(gen::render(changes), HasSubstr(text));
  }
}

TEST(Diff, SameDialectHasNoChange) {
  EXPECT_TRUE(gen::compare(load(kCommon), load(kCommon)).empty());
}

// --- the program
// ---------------------------------------------------------------------------------

TEST(Program, ExitCodesSayWhatHappened) {
  const TemporaryFolder folder;
  const auto good = folder.write("good.xml", kBefore).string();
  const auto bad = folder.write("bad.xml", "<mavlink><messages><x/></messages></mavlink>").string();
  auto changed_text = kBefore;
  changed_text.replace(changed_text.find("uint16_t"), 8, "uint32_t");
  const auto changed = folder.write("changed.xml", changed_text).string();
  const auto out = (folder.path() / "out").string();
  EXPECT_EQ(run("check " + good).code, 0);
  EXPECT_EQ(run("check " + bad).code, 1);
  EXPECT_EQ(run("check").code, 2);
  EXPECT_EQ(run("frobnicate").code, 2);
  EXPECT_EQ(run("generate --out /proc/nowhere " + good).code, 3);
  EXPECT_EQ(run("diff " + good + ' ' + changed).code, 4);
  EXPECT_EQ(run("diff " + good + ' ' + good).code, 0);
  EXPECT_EQ(run("generate --out " + out + ' ' + good).code, 0);
  EXPECT_EQ(run("--version").code, 0);
}

/// Compiles and runs one source with a folder of headers.
Outcome compile_and_run(const std::filesystem::path& folder, const std::string& source) {
  const TemporaryFolder work;
  const auto file = work.write("use.cpp", source).string();
  const auto program = (work.path() / "use").string();
  return shell(CAS_CXX " -std=c++20 -fno-exceptions -Wall -Wextra -Werror -I" + folder.string() +
               " -o " + program + ' ' + file + " 2>&1 && " + program);
}

const std::string kSendAndReceive = R"(
int main() {
  using namespace cas::mav;
  namespace tiny = mavlink::tiny;
  Encoder encode_packet({.system = 1, .component = 1});
  int heartbeats = 0;
  PacketParser parser(tiny::table());
  parser.feed(encode_packet(tiny::Heartbeat{.type = tiny::MavType::kQuadrotor}),
              [&](const PacketView& packet) { heartbeats += decode<tiny::Heartbeat>(packet)->type ==
                                                            tiny::MavType::kQuadrotor; });
  write_text(tiny::Heartbeat{}, [](std::string_view) {});
  return heartbeats == 1 ? 0 : 1;
})";

TEST(Program, FolderWithTheRuntimeNeedsTheStandardLibraryAlone) {
  const TemporaryFolder folder;
  const auto outcome = run("generate --with-runtime --only HEARTBEAT --name tiny --out " +
                           folder.path().string() + ' ' + kCommon);
  ASSERT_EQ(outcome.code, 0) << outcome.output;
  const auto built = compile_and_run(folder.path(), R"(#include "mavlink/tiny/all.hpp"
#include "mavlink/tiny/enum_text.hpp"
#include "mavlink_gen/runtime/packet_parser.hpp"
#include "mavlink_gen/runtime/print.hpp"
)" + kSendAndReceive);
  EXPECT_EQ(built.code, 0) << built.output;
}

TEST(Program, OneHeaderHoldsADialectAndMeetsThatOfAnother) {
  const TemporaryFolder folder;
  for (const std::string name : {"tiny", "other"}) {
    const auto outcome = run("generate --single --only HEARTBEAT --name " + name + " --out " +
                             folder.path().string() + ' ' + kCommon);
    ASSERT_EQ(outcome.code, 0) << outcome.output;
  }
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "mavlink_gen"));
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "mavlink/tiny"));
  const auto built = compile_and_run(folder.path(), R"(#include "mavlink/other.hpp"
#include "mavlink/tiny.hpp"
static_assert(mavlink::other::Heartbeat::kId == 0);
)" + kSendAndReceive);
  EXPECT_EQ(built.code, 0) << built.output;
}

TEST(Program, TwoDialectsOfOneNameAreRefused) {
  const TemporaryFolder folder;
  std::filesystem::create_directories(folder.path() / "other");
  std::string changed = kBefore;
  changed.replace(changed.find("uint16_t"), 8, "uint32_t");
  const auto one = folder.write("twin.xml", kBefore).string();
  const auto two = folder.write("other/twin.xml", changed).string();
  for (const std::string single : {"", "--single "}) {
    const auto outcome = run("generate " + single + "--out " + (folder.path() / "out").string() +
                             ' ' + one + ' ' + two);
    EXPECT_EQ(outcome.code, 2) << outcome.output;
    EXPECT_FALSE(std::filesystem::exists(folder.path() / "out"));
  }
}

TEST(Program, ForgottenEnumTextIsOneReadableError) {
  const TemporaryFolder folder;
  ASSERT_EQ(run("generate --with-runtime --only HEARTBEAT --out " + folder.path().string() + ' ' +
                kCommon)
                .code,
            0);
  const auto built = compile_and_run(folder.path(), R"(#include "mavlink/common/heartbeat.hpp"
#include "mavlink_gen/runtime/print.hpp"
int main() { cas::mav::write_text(mavlink::common::Heartbeat{}, [](std::string_view) {}); })");
  EXPECT_NE(built.code, 0);
  const auto error = built.output.find("error:");
  ASSERT_NE(error, std::string::npos) << built.output;
  EXPECT_THAT(built.output, HasSubstr("include mavlink/<dialect>/enum_text.hpp"));
  EXPECT_EQ(built.output.find("error:", error + 1), std::string::npos) << built.output;
}

TEST(Program, NamesOfTheXmlAreFoundInTheCode) {
  const auto files = gen::write_cpp(load(kCommon), "common");
  const auto& enums = files.at("mavlink/common/enums.hpp");
  EXPECT_THAT(enums, HasSubstr("kNavTakeoff = 22,  // MAV_CMD_NAV_TAKEOFF\n"));
  EXPECT_THAT(enums, HasSubstr("enum class MavResult : std::uint8_t {  // MAV_RESULT\n"));
}

TEST(Program, FaultyInputWritesNothing) {
  const TemporaryFolder folder;
  const auto bad = folder.write("bad.xml", "<mavlink><messages><x/></messages></mavlink>").string();
  const auto out = folder.path() / "out";
  const auto outcome = run("generate --out " + out.string() + ' ' + bad);
  EXPECT_EQ(outcome.code, 1);
  EXPECT_THAT(outcome.output, HasSubstr("bad.xml:1:20: error: <x> is not allowed in <messages>"));
  EXPECT_FALSE(std::filesystem::exists(out));
}

TEST(Program, TextOfAFileGivesTheTerminalNoOrders) {
  const TemporaryFolder folder;
  const auto bad = folder.write("bad.xml", "<mavlink><messages><x\u202E/></messages></mavlink>");
  const auto outcome = run("check " + bad.string());
  EXPECT_EQ(outcome.code, 1);
  EXPECT_THAT(outcome.output, testing::Not(HasSubstr("\u202E")));
}

TEST(Program, StrictTakesWarningsForErrors) {
  const TemporaryFolder folder;
  const auto file =
      folder.write("w.xml", "<mavlink><enums><enum name=\"E\" colour=\"red\"/></enums></mavlink>");
  EXPECT_EQ(run("check " + file.string()).code, 0);
  EXPECT_EQ(run("check --strict " + file.string()).code, 1);
  const auto unfit = run("check --strict " + kDialects + "every_construct.xml");
  EXPECT_EQ(unfit.code, 1);
  EXPECT_THAT(unfit.output, HasSubstr("narrow is uint16_t, but the highest value of WIDE_FLAGS"));
}

}  // namespace
