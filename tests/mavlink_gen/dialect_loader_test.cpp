// SPDX-License-Identifier: BSD-3-Clause
#include "mavlink_gen/parser/dialect_loader.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "mavlink_gen/generator/writers.hpp"
#include "mavlink_gen/runtime/public_table.hpp"
#include "tests/support/paths.hpp"

namespace {

using namespace cas::mav::xml;

Dialect load(const std::filesystem::path& file, std::size_t warnings = 0) {
  Diagnostics diagnostics;
  auto dialect = load_dialect(file, diagnostics);
  EXPECT_EQ(diagnostics.error_count(), 0U) << diagnostics.render();
  EXPECT_EQ(diagnostics.warning_count(), warnings) << diagnostics.render();
  return dialect.value_or(Dialect{});
}

Dialect every_construct() {
  constexpr std::size_t kUnfitFields = 2;  // CRANE_BEAT.state, CRANE_STATUS.narrow
  return load(cas::test::source_dir() + "/tests/mavlink_gen/dialects/every_construct.xml",
              kUnfitFields);
}

const Entry* entry(const Dialect& dialect, const char* enum_name, const std::string& name) {
  const auto* item = dialect.find_enum(enum_name);
  if (item == nullptr) return nullptr;
  for (const auto& candidate : item->entries) {
    if (candidate.name == name) return &candidate;
  }
  return nullptr;
}

TEST(DialectLoader, MergesEnumsOfAllFilesOnceEach) {
  const auto dialect = every_construct();
  EXPECT_EQ(dialect.files.size(), 3U);
  const auto* state = dialect.find_enum("CRANE_STATE");
  ASSERT_NE(state, nullptr);
  ASSERT_EQ(state->entries.size(), 4U);
  EXPECT_EQ(state->entries[2].name, "CRANE_STATE_LOWERING");
  EXPECT_EQ(state->bytes, 2);
  EXPECT_EQ(state->text, "Grows over three files.");
}

TEST(DialectLoader, ReadsEveryKindOfNumber) {
  const auto dialect = every_construct();
  const auto value = [&](const char* enum_name, const char* name) {
    const auto* found = entry(dialect, enum_name, name);
    return found == nullptr ? std::string("missing") : found->value.decimal();
  };
  EXPECT_EQ(value("NUMBERS", "NUMBERS_NEGATIVE"), "-5");
  EXPECT_EQ(value("NUMBERS", "NUMBERS_AFTER_NEGATIVE"), "-4");
  EXPECT_EQ(value("NUMBERS", "NUMBERS_HEX"), "31");
  EXPECT_EQ(value("NUMBERS", "NUMBERS_BINARY"), "33");
  EXPECT_EQ(value("NUMBERS", "NUMBERS_AFTER_BINARY"), "34");
  EXPECT_EQ(value("NUMBERS", "NUMBERS_POWER"), "1048576");
  EXPECT_EQ(value("NUMBERS", "NUMBERS_LARGEST"), "9223372036854775807");
  EXPECT_EQ(value("WIDE_FLAGS", "WIDE_FLAGS_HIGHEST"), "9223372036854775808");
  EXPECT_EQ(value("WIDE_FLAGS", "WIDE_FLAGS_ALL"), "18446744073709551615");
  EXPECT_TRUE(dialect.find_enum("NUMBERS")->is_signed);
}

TEST(DialectLoader, ReadsLifecycleAndParameters) {
  const auto dialect = every_construct();
  EXPECT_EQ(dialect.find_enum("SMALL_FLAGS")->lifecycle.status, Status::kWip);
  EXPECT_TRUE(dialect.find_enum("SMALL_FLAGS")->bitmask) << "a field shows it as one";
  EXPECT_EQ(entry(dialect, "SMALL_FLAGS", "SMALL_FLAGS_A")->lifecycle.replaced_by, "SMALL_FLAGS_B");
  EXPECT_EQ(dialect.find_message("CRANE_STATUS")->lifecycle.since, "2026-01");
  const auto* lift = entry(dialect, "CRANE_CMD", "CRANE_CMD_LIFT");
  ASSERT_NE(lift, nullptr);
  EXPECT_EQ(lift->lifecycle.status, Status::kSuperseded);
  EXPECT_TRUE(lift->has_location);
  EXPECT_FALSE(lift->is_destination);
  EXPECT_TRUE(lift->mission_only);
  ASSERT_EQ(lift->params.size(), 3U);
  EXPECT_EQ(lift->params[0].label, "Mass");
  EXPECT_EQ(lift->params[0].increment, "0.5");
  EXPECT_TRUE(lift->params[2].reserved);
}

TEST(DialectLoader, VersionIsThatOfTheFileWithTheField) {
  const auto dialect = every_construct();
  EXPECT_EQ(dialect.version, 9);
  EXPECT_EQ(dialect.number, 42);
  EXPECT_EQ(dialect.find_message("CRANE_BEAT")->fields[1].version, 7);
}

TEST(DialectLoader, ExtensionsFollowUnsortedAndUnpadded) {
  const auto dialect = every_construct();
  const auto* message = dialect.find_message("CRANE_STATUS");
  ASSERT_NE(message, nullptr);
  EXPECT_EQ(message->min_length, 6U);
  EXPECT_EQ(message->max_length, 11U);
  EXPECT_EQ(message->fields[4].offset, 6U);
  EXPECT_EQ(message->fields[5].offset, 7U);
  EXPECT_EQ(message->byte_field_offset("target_system"), 4);
  EXPECT_EQ(message->byte_field_offset("late"), 6);
  EXPECT_EQ(message->byte_field_offset("none"), -1);
}

TEST(OurDialect, IsTheFactsOfTheMessagesWeSpeak) {
  const auto dialect = load(cas::test::source_dir() + "/mavlink_gen/dialects/common.xml");
  std::ifstream file(cas::test::source_dir() + "/tests/golden/mavlink_messages.json");
  const auto facts = nlohmann::json::parse(file);
  ASSERT_EQ(dialect.messages.size(), facts["messages"].size());
  for (std::size_t i = 0; i < dialect.messages.size(); ++i) {
    const auto& message = dialect.messages[i];
    const auto& fact = facts["messages"][i];
    SCOPED_TRACE(message.name);
    EXPECT_EQ(fact[0], message.id);
    EXPECT_EQ(fact[1], message.name);
    EXPECT_EQ(fact[2], message.crc_extra);
    EXPECT_EQ(fact[3], message.min_length);
    EXPECT_EQ(fact[4], message.max_length);
    EXPECT_FALSE(message.text.empty());
    ASSERT_EQ(fact[5].size(), message.fields.size());
    for (std::size_t f = 0; f < message.fields.size(); ++f) {
      const auto& field = message.fields[f];
      const auto& row = fact[5][f];
      EXPECT_EQ(row[0], field.name);
      EXPECT_EQ(row[1], wire_name(field.type));
      EXPECT_EQ(row[2], field.array_length);
      EXPECT_EQ(row[3], field.offset);
      EXPECT_EQ(row[4] == 1, field.extension);
      EXPECT_EQ(row[5].is_null() ? "" : row[5].get<std::string>(), field.enum_name);
      EXPECT_FALSE(field.text.empty()) << field.name << " has no description";
    }
  }
  ASSERT_EQ(dialect.enums.size(), facts["enums"].size());
  for (const auto& fact : facts["enums"]) {
    const auto* item = dialect.find_enum(fact[0].get<std::string>());
    ASSERT_NE(item, nullptr) << fact[0];
    EXPECT_EQ(fact[1] == 1, item->bitmask) << item->name;
    ASSERT_EQ(fact[2].size(), item->entries.size()) << item->name;
    for (const auto& row : fact[2]) {
      const auto* found = entry(dialect, item->name.c_str(), row[0].get<std::string>());
      ASSERT_NE(found, nullptr) << row[0];
      EXPECT_EQ(row[1].dump(), found->value.decimal()) << found->name;
    }
  }
}

/// The public files are no part of the project; the user may name their folder.
TEST(PublicDialects, AreReadWithTheLayoutOfTheRoutingTable) {
  const char* folder = std::getenv("CAS_MAVLINK_DEFINITIONS");
  if (folder == nullptr) GTEST_SKIP() << "CAS_MAVLINK_DEFINITIONS names no folder";
  constexpr std::size_t kUnfitFields = 1;  // GIMBAL_DEVICE_INFORMATION.cap_flags
  const auto dialect = load(std::filesystem::path(folder) / "all.xml", kUnfitFields);
  std::size_t compared = 0;
  for (const auto& message : dialect.messages) {
    const auto* info = cas::mav::public_table().find(message.id);
    if (info == nullptr) continue;
    ++compared;
    EXPECT_EQ(info->name, message.name);
    EXPECT_EQ(info->crc_extra, message.crc_extra) << message.name;
    EXPECT_EQ(info->min_length, message.min_length) << message.name;
    EXPECT_EQ(info->max_length, message.max_length) << message.name;
    EXPECT_EQ(info->target_system_offset, message.byte_field_offset("target_system"));
    EXPECT_EQ(info->target_component_offset, message.byte_field_offset("target_component"));
  }
  EXPECT_EQ(compared, cas::mav::public_table().all().size());
}

}  // namespace
