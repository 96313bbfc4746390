// SPDX-License-Identifier: BSD-3-Clause
#include "hils/mcap/read_mcap.hpp"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.hpp"
#include "tests/hils/mcap/mcap_bytes.hpp"
#include "tests/support/refusal.hpp"

namespace cas::hils {
namespace {

using cas::test::mcap_compressed;
using cas::test::mcap_crc32;
using cas::test::McapBytes;
using Strings = std::vector<std::string>;

/// The contents of a file, a line for each.
class McapLines final : public McapListener {
 public:
  explicit McapLines(std::string_view bytes) { cut_at = read_mcap(bytes, *this); }

  void on_metadata(std::string_view name,
                   const std::map<std::string, std::string>& facts) override {
    for (const auto& [key, value] : facts)
      lines.push_back(std::string(name) + ": " + key + "=" + value);
  }
  void on_message(const McapChannel& channel, std::uint64_t time_ns,
                  std::string_view data) override {
    lines.push_back(channel.topic + " (" + channel.schema + ", " + channel.encoding + ") " +
                    std::to_string(time_ns) + ": " + std::string(data));
  }

  Strings lines;
  std::optional<std::size_t> cut_at;
};

McapBytes simple() {
  return McapBytes().schema(4, "Point").channel(9, 4, "/point").message(9, 5, "{}");
}
const std::string kFirst = "/point (Point, json) 5: {}";

std::string records() {
  return McapBytes::of_records().channel(10, 0, "/raw", "cdr").message(10, 7, "abc").bytes();
}
TEST(ReadMcap, ReadsMessagesInAndOutsideOfChunks) {
  const std::string plain = records();
  const std::string metadata =
      McapBytes::text("facts") + McapBytes::text(McapBytes::text("a") + McapBytes::text("b"));
  const std::string file =
      simple()
          .chunk("", plain, plain.size(), 0)
          .chunk("zstd", mcap_compressed(plain), plain.size(), mcap_crc32(plain))
          .add(0x0C, metadata)
          .add(0x90, "of its writer alone")
          .message(9, 8, "[]")
          .whole();
  const McapLines read(file);
  EXPECT_EQ(read.lines, (Strings{kFirst, "/raw (, cdr) 7: abc", "/raw (, cdr) 7: abc", "facts: a=b",
                                 "/point (Point, json) 8: []"}));
  EXPECT_FALSE(read.cut_at);
}

TEST(ReadMcap, ReadsATruncatedFileUpToItsCutAndTellsWhere) {
  const std::string before = simple().bytes();
  const std::string whole = simple().message(9, 8, "[]").bytes();
  for (std::size_t size = before.size(); size < whole.size(); ++size) {
    const McapLines read(whole.substr(0, size));
    EXPECT_EQ(read.lines, Strings{kFirst}) << size;
    EXPECT_EQ(read.cut_at, before.size()) << size;
  }
}

struct BrokenCase {
  const char* name;
  std::string bytes;
  std::string sentence;
};

class BrokenMcap : public testing::TestWithParam<BrokenCase> {};

TEST_P(BrokenMcap, IsRefusedWithItsPlace) {
  EXPECT_EQ(test::refusal([] { const McapLines read(GetParam().bytes); }), GetParam().sentence);
}

std::vector<BrokenCase> broken_cases() {
  const std::size_t at = simple().bytes().size();
  const std::string byte = "byte " + std::to_string(at);
  const std::string chunk = byte + " (record of type 0x06): ";
  const std::string plain = records();
  const std::string stored = mcap_compressed(plain);
  const std::string whole = simple().whole();
  std::string other_version = whole;
  other_version[5] = '1';
  const std::string of_data = McapBytes().add(0x0F, McapBytes::number(std::uint32_t{1})).bytes();
  const std::size_t start = McapBytes().bytes().size();
  const auto number = [](auto value) { return McapBytes::number(value); };
  const std::string footer = McapBytes().add(0x0F, number(std::uint32_t{0})).bytes();
  return {
      {"Empty", "", "byte 0: this is no MCAP: it does not begin as one"},
      {"Text", "time_s,x_m\n", "byte 0: this is no MCAP: it does not begin as one"},
      {"Version", other_version, "byte 5: an MCAP of another version than 0, the one that is read"},
      {"NoHeader", std::string(McapBytes::kMagic) + McapBytes::record(0x03, "abc"),
       "byte 8: the first record is no header"},
      {"UnknownChannel", simple().message(8, 5, "{}").whole(),
       byte + " (record of type 0x05): a message of a channel that it does not have"},
      {"ShortField", simple().add(0x04, "abc").whole(),
       byte + " (record of type 0x04): the record ends within a field of 2 bytes, of which it has "
              "1"},
      {"LongName", simple().channel(1, 0, std::string(1025, 'a')).whole(),
       byte + " (record of type 0x04): a name has 1025 bytes, and at most 1024 are read"},
      {"Lz4", simple().chunk("lz4", "abc", 9, 0).whole(),
       chunk + "a chunk compressed with `lz4`; zstd and none are read"},
      {"LargeChunk", simple().chunk("zstd", stored, std::uint64_t{1} << 40U, 0).whole(),
       chunk + "a chunk of 1099511627776 bytes, and at most 256 MiB are read"},
      {"WrongSize", simple().chunk("zstd", stored, plain.size() + 1, 0).whole(),
       chunk + "a chunk of " + std::to_string(plain.size()) + " bytes that says it has " +
           std::to_string(plain.size() + 1)},
      {"TooSmall", simple().chunk("zstd", stored, plain.size() - 1, 0).whole(),
       chunk + "the chunk is not what zstd wrote: Destination buffer is too small"},
      {"NoZstd", simple().chunk("zstd", std::string(20, 'a'), 20, 0).whole(),
       chunk + "the chunk is not what zstd wrote: Unknown frame descriptor"},
      {"Checksum", simple().chunk("", plain, plain.size(), 1).whole(),
       chunk + "the chunk does not have its checksum"},
      {"CutChunk",
       simple().chunk("", plain.substr(0, plain.size() - 1), plain.size() - 1, 0).whole(),
       chunk + "the chunk ends within the record at its byte " +
           std::to_string(McapBytes::of_records().channel(10, 0, "/raw", "cdr").bytes().size())},
      {"UnknownChannelInAChunk",
       simple().chunk("", McapBytes::record(0x05, std::string(22, '\1')), 31, 0).whole(),
       byte + ", in the chunk there at byte 0: a message of a channel that it does not have"},
      {"LengthBeyondTheEnd",
       simple().bytes() + std::string(9, '\5') + std::string(McapBytes::kMagic),
       byte + ": a record that is longer than the rest of the file"},
      {"Data", of_data,
       "byte " + std::to_string(start) +
           " (record of type 0x0f): the data before it do not have their checksum"},
      {"NoEnd", whole + "more",
       "byte " + std::to_string(whole.size() - 8) + ": behind the footer is no end of an MCAP"},
      {"Summary",
       footer +
           McapBytes::record(0x02, number(std::uint64_t{9}) + number(std::uint64_t{0}) +
                                       number(std::uint32_t{1})) +
           std::string(McapBytes::kMagic),
       "byte " + std::to_string(footer.size()) +
           " (record of type 0x02): the summary does not have its checksum"},
      {"SummaryBehindTheFooter",
       footer +
           McapBytes::record(0x02, number(~std::uint64_t{0}) + number(std::uint64_t{0}) +
                                       number(std::uint32_t{1})) +
           std::string(McapBytes::kMagic),
       "byte " + std::to_string(footer.size()) +
           " (record of type 0x02): the summary begins behind the footer"},
  };
}

INSTANTIATE_TEST_SUITE_P(Each, BrokenMcap, testing::ValuesIn(broken_cases()),
                         [](const auto& test) { return std::string(test.param.name); });

TEST(ReadMcap, BoundsChannels) {
  McapBytes many;
  for (int id = 0; id <= 10'000; ++id) many.channel(static_cast<std::uint16_t>(id), 0, "/a");
  EXPECT_THROW(McapLines{many.whole()}, base::ConfigError);
}

TEST(ReadMcap, RefusesAFlippedByteOfACompressedChunk) {
  const std::string plain = records();
  const std::string stored = mcap_compressed(plain);
  const std::string good = simple().chunk("zstd", stored, plain.size(), mcap_crc32(plain)).whole();
  EXPECT_EQ(McapLines(good).lines.size(), 2U);
  const std::size_t end = good.find(stored) + stored.size();
  for (std::size_t at = end - stored.size(); at < end; ++at) {
    std::string broken = good;
    broken[at] = static_cast<char>(broken[at] ^ 0x21);
    try {
      // A bit that the format does not use may be flipped without loss.
      EXPECT_EQ(McapLines(broken).lines, McapLines(good).lines) << at;
    } catch (const base::ConfigError&) {
    }
  }
}

}  // namespace
}  // namespace cas::hils
