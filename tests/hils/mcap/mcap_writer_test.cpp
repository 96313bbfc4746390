// SPDX-License-Identifier: BSD-3-Clause
#include "hils/mcap/mcap_writer.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "hils/mcap/read_mcap.hpp"
#include "tests/hils/mcap/mcap_bytes.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::hils {
namespace {

using base::SimTime;
using cas::test::mcap_compressed;
using cas::test::mcap_crc32;
using cas::test::McapBytes;
using std::chrono::milliseconds;

template <class T>
std::string number(T value) {
  return McapBytes::number(value);
}
std::string text(std::string_view value) { return McapBytes::text(value); }

/// Two schemas, two channels, three messages in two chunks.
std::string written(const cas::test::TemporaryFolder& folder) {
  McapWriter file({folder.path(), "a.mcap"}, "a test", 150);
  file.write_metadata("cas", {{"seed", "7"}});
  const std::uint16_t first = file.add_schema("First", R"({"type":"object"})");
  const std::uint16_t unused = file.add_schema("Unused", "{}");
  const std::uint16_t a = file.add_channel(first, "/a");
  file.add_channel(unused, "/unused");
  const std::uint16_t b = file.add_channel(first, "/b");
  file.write(b, SimTime(milliseconds(5)), R"({"x":1})");
  file.write(a, SimTime(milliseconds(6)), R"({"x":2})");
  file.write(b, SimTime(milliseconds(9)), R"({"x":3})");
  file.close();
  return cas::test::TemporaryFolder::read(folder / "a.mcap");
}

/// A chunk with the index of its messages.
struct Chunk {
  std::string bytes;
  std::string index;  ///< its record in the summary
};

/// @param at  of the chunk in the file
/// @param messages  index records: channel, then time and place of each message
Chunk chunk(std::uint64_t at, std::uint64_t first_ns, std::uint64_t last_ns,
            const std::string& records,
            const std::vector<std::pair<std::uint16_t, std::string>>& messages) {
  const std::string stored = mcap_compressed(records);
  Chunk made;
  made.bytes = McapBytes::record(0x06, number(first_ns) + number(last_ns) +
                                           number(std::uint64_t{records.size()}) +
                                           number(mcap_crc32(records)) + text("zstd") +
                                           number(std::uint64_t{stored.size()}) + stored);
  const std::uint64_t chunk_length = made.bytes.size();
  std::string places;
  for (const auto& [channel, entries] : messages) {
    places += number(channel) + number(std::uint64_t{at + made.bytes.size()});
    made.bytes += McapBytes::record(0x07, number(channel) + text(entries));
  }
  made.index = McapBytes::record(
      0x08, number(first_ns) + number(last_ns) + number(at) + number(chunk_length) + text(places) +
                number(std::uint64_t{made.bytes.size() - chunk_length}) + text("zstd") +
                number(std::uint64_t{stored.size()}) + number(std::uint64_t{records.size()}));
  return made;
}

TEST(McapWriter, WritesTheBytesOfTheSpecification) {
  constexpr std::uint64_t kMs = 1'000'000;
  const std::string metadata =
      McapBytes::record(0x0C, text("cas") + text(text("seed") + text("7")));
  std::string file = McapBytes().bytes();
  const std::uint64_t metadata_at = file.size();
  file += metadata;

  // A channel is declared with its first message: /b, which has id 3, before /a.
  const std::string schema =
      McapBytes::of_records().schema(1, "First", R"({"type":"object"})").bytes();
  const std::string channel_b = McapBytes::of_records().channel(3, 1, "/b").bytes();
  const std::string channel_a = McapBytes::of_records().channel(1, 1, "/a").bytes();
  const std::string b1 = McapBytes::of_records().message(3, 5 * kMs, R"({"x":1})", 0).bytes();
  const std::string a1 = McapBytes::of_records().message(1, 6 * kMs, R"({"x":2})", 0).bytes();
  const std::string b2 = McapBytes::of_records().message(3, 9 * kMs, R"({"x":3})", 1).bytes();
  const std::uint64_t b1_at = schema.size() + channel_b.size();
  const Chunk first = chunk(file.size(), 5 * kMs, 5 * kMs, schema + channel_b + b1,
                            {{std::uint16_t{3}, number(5 * kMs) + number(b1_at)}});
  file += first.bytes;
  const std::uint64_t a1_at = channel_a.size();
  const Chunk second =
      chunk(file.size(), 6 * kMs, 9 * kMs, channel_a + a1 + b2,
            {{std::uint16_t{1}, number(6 * kMs) + number(a1_at)},
             {std::uint16_t{3}, number(9 * kMs) + number(std::uint64_t{a1_at + a1.size()})}});
  file += second.bytes;
  file += McapBytes::record(0x0F, number(mcap_crc32(file)));

  const std::uint64_t summary_at = file.size();
  std::string offsets;
  const auto group = [&](int opcode, const std::string& records) {
    offsets += McapBytes::record(0x0E, number(static_cast<std::uint8_t>(opcode)) +
                                           number(std::uint64_t{file.size()}) +
                                           number(std::uint64_t{records.size()}));
    file += records;
  };
  group(0x03, schema);
  group(0x04, channel_a + channel_b);
  group(0x0B,
        McapBytes::record(0x0B, number(std::uint64_t{3}) + number(std::uint16_t{1}) +
                                    number(std::uint32_t{2}) + number(std::uint32_t{0}) +
                                    number(std::uint32_t{1}) + number(std::uint32_t{2}) +
                                    number(5 * kMs) + number(9 * kMs) +
                                    text(number(std::uint16_t{1}) + number(std::uint64_t{1}) +
                                         number(std::uint16_t{3}) + number(std::uint64_t{2}))));
  group(0x08, first.index + second.index);
  group(0x0D, McapBytes::record(0x0D, number(metadata_at) + number(std::uint64_t{metadata.size()}) +
                                          text("cas")));
  const std::uint64_t offsets_at = file.size();
  file += offsets;
  file += '\x02' + number(std::uint64_t{20}) + number(summary_at) + number(offsets_at);
  file += number(mcap_crc32(std::string_view(file).substr(summary_at)));
  file += McapBytes::kMagic;

  const cas::test::TemporaryFolder folder;
  EXPECT_EQ(written(folder), file);
}

TEST(McapWriter, WritesAChunkAsSoonAsItIsFull) {
  const cas::test::TemporaryFolder folder;
  constexpr std::size_t kChunk = 4096;
  McapWriter file({folder.path(), "a.mcap"}, "a test", kChunk);
  const std::uint16_t channel = file.add_channel(file.add_schema("Text", "{}"), "/a");
  std::string noise;
  for (unsigned i = 0; i < 40'000; ++i) noise += static_cast<char>('a' + i * i % 997 % 26);
  for (int i = 0; i < 200; ++i) {
    file.write(channel, SimTime(milliseconds(i)),
               '"' + noise.substr(static_cast<std::size_t>(i) * 100, 1000) + '"');
  }
  // Buffers of C hold some kilobytes more.
  EXPECT_GT(std::filesystem::file_size(folder / "a.mcap"), 8192U);
  file.write(channel, SimTime(milliseconds(200)), '"' + noise + '"');  // larger than a chunk
  file.close();
  struct Count final : McapListener {
    void on_message(const McapChannel&, std::uint64_t, std::string_view data) override {
      ++messages;
      most = std::max(most, data.size());
    }
    int messages = 0;
    std::size_t most = 0;
  } count;
  EXPECT_FALSE(read_mcap(cas::test::TemporaryFolder::read(folder / "a.mcap"), count));
  EXPECT_EQ(count.messages, 201);
  EXPECT_EQ(count.most, noise.size() + 2);
}

}  // namespace
}  // namespace cas::hils
