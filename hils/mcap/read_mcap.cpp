// SPDX-License-Identifier: BSD-3-Clause
#include "hils/mcap/read_mcap.hpp"

#include <fmt/format.h>
#include <zlib.h>
#include <zstd.h>

#include <cstring>
#include <unordered_map>

#include "base/error.hpp"
#include "base/printable.hpp"
#include "hils/mcap/mcap_format.hpp"

namespace cas::hils {

namespace {

constexpr std::uint64_t kMostMcapChunkBytes = std::uint64_t{256} << 20U;
constexpr std::uint64_t kMostMcapBytes = std::uint64_t{4} << 30U;
constexpr std::size_t kMostMcapChannels = 10'000;
constexpr std::size_t kMostMcapNameBytes = 1024;
constexpr std::size_t kMostMcapFacts = 1000;

std::uint32_t mcap_crc_of(std::string_view bytes) {
  return static_cast<std::uint32_t>(::crc32_z(0, reinterpret_cast<const Bytef*>(bytes.data()),
                                              static_cast<z_size_t>(bytes.size())));
}

/// Reads a record's content field by field.
class McapContentReader {
 public:
  /// @param place  of the record, for errors
  McapContentReader(std::string_view content, std::string place)
      : left_(content), place_(std::move(place)) {}

  template <class T>
  T number() {
    T value{};
    std::memcpy(&value, take(sizeof value).data(), sizeof value);
    return value;
  }
  std::string_view bytes(std::uint64_t count) { return take(count); }
  /// With its length before it.
  std::string_view text() { return take(number<std::uint32_t>()); }
  std::string name() {
    const std::string_view word = text();
    if (word.size() > kMostMcapNameBytes) {
      fail(fmt::format("a name has {} bytes, and at most {} are read", word.size(),
                       kMostMcapNameBytes));
    }
    return std::string(word);
  }
  std::string_view rest() const { return left_; }
  const std::string& place() const { return place_; }
  [[noreturn]] void fail(std::string_view what) const {
    throw base::ConfigError(fmt::format("{}: {}", place_, what));
  }

 private:
  std::string_view take(std::uint64_t count) {
    if (count > left_.size()) {
      fail(fmt::format("the record ends within a field of {} bytes, of which it has {}", count,
                       left_.size()));
    }
    const std::string_view taken = left_.substr(0, count);
    left_.remove_prefix(count);
    return taken;
  }

  std::string_view left_;
  std::string place_;
};

struct McapRecord {
  McapOpcode opcode{};
  std::string_view content;
  std::size_t place = 0;  ///< of its first byte
  std::size_t end = 0;
};

/// The record at a place; nullopt: it is not whole.
std::optional<McapRecord> mcap_record_at(std::string_view bytes, std::size_t place) {
  if (bytes.size() - place < kMcapRecordHead) return std::nullopt;
  std::uint64_t length = 0;
  std::memcpy(&length, bytes.data() + place + 1, sizeof length);
  const std::size_t begin = place + kMcapRecordHead;
  if (length > bytes.size() - begin) return std::nullopt;
  return McapRecord{.opcode = static_cast<McapOpcode>(bytes[place]),
                    .content = bytes.substr(begin, length),
                    .place = place,
                    .end = begin + length};
}

class McapReader {
 public:
  McapReader(std::string_view bytes, McapListener& listener) : bytes_(bytes), listener_(listener) {}

  std::optional<std::size_t> read() {
    if (!bytes_.starts_with(kMcapMagic.substr(0, 5))) {
      throw base::ConfigError("byte 0: this is no MCAP: it does not begin as one");
    }
    if (!bytes_.starts_with(kMcapMagic)) {
      throw base::ConfigError("byte 5: an MCAP of another version than 0, the one that is read");
    }
    std::size_t at = kMcapMagic.size();
    while (true) {
      const auto record = mcap_record_at(bytes_, at);
      if (!record) return cut_at(at);
      if (at == kMcapMagic.size() && record->opcode != McapOpcode::kHeader) {
        throw base::ConfigError(fmt::format("byte {}: the first record is no header", at));
      }
      at = record->end;
      if (record->opcode == McapOpcode::kFooter) {
        check_end(*record);
        return std::nullopt;
      }
      on_record(*record);
    }
  }

 private:
  /// A file that ends as one is not truncated: a length in it is wrong.
  std::size_t cut_at(std::size_t at) const {
    if (at + kMcapMagic.size() <= bytes_.size() && bytes_.ends_with(kMcapMagic)) {
      throw base::ConfigError(
          fmt::format("byte {}: a record that is longer than the rest of the file", at));
    }
    return at;
  }

  static std::string place_of(const McapRecord& record) {
    return fmt::format("byte {} (record of type 0x{:02x})", record.place,
                       static_cast<unsigned>(record.opcode));
  }

  void check_end(const McapRecord& footer) const {
    if (bytes_.substr(footer.end) != kMcapMagic) {
      throw base::ConfigError(
          fmt::format("byte {}: behind the footer is no end of an MCAP", footer.end));
    }
    McapContentReader content(footer.content, place_of(footer));
    const auto summary = content.number<std::uint64_t>();
    content.number<std::uint64_t>();
    const auto crc = content.number<std::uint32_t>();
    if (summary > footer.place) content.fail("the summary begins behind the footer");
    if (crc == 0 || summary == 0) return;
    const std::size_t end = footer.end - sizeof crc;
    if (mcap_crc_of(bytes_.substr(summary, end - summary)) != crc) {
      content.fail("the summary does not have its checksum");
    }
  }

  void on_record(const McapRecord& record) {
    McapContentReader content(record.content, place_of(record));
    switch (record.opcode) {
      case McapOpcode::kChunk:
        return on_chunk(content, record);
      case McapOpcode::kMetadata:
        return on_metadata(content);
      case McapOpcode::kDataEnd: {
        const auto crc = content.number<std::uint32_t>();
        if (crc != 0 && mcap_crc_of(bytes_.substr(0, record.place)) != crc) {
          content.fail("the data before it do not have their checksum");
        }
        in_summary_ = true;
        return;
      }
      default:
        if (!in_summary_) on_content(record.opcode, content);
    }
  }

  /// Handles the records that may be in a chunk.
  void on_content(McapOpcode opcode, McapContentReader& content) {
    switch (opcode) {
      case McapOpcode::kSchema: {
        const auto id = content.number<std::uint16_t>();
        if (id != 0) schemas_[id] = content.name();
        return;
      }
      case McapOpcode::kChannel:
        return on_channel(content);
      case McapOpcode::kMessage: {
        const auto channel = channels_.find(content.number<std::uint16_t>());
        if (channel == channels_.end())
          content.fail("a message of a channel that it does not have");
        content.number<std::uint32_t>();  // sequence
        const auto time_ns = content.number<std::uint64_t>();
        content.number<std::uint64_t>();  // time of publication
        return listener_.on_message(channel->second, time_ns, content.rest());
      }
      default:
        return;  // indexes, attachments, records of other versions
    }
  }

  void on_channel(McapContentReader& content) {
    const auto id = content.number<std::uint16_t>();
    if (channels_.contains(id)) return;
    if (channels_.size() == kMostMcapChannels) {
      content.fail(fmt::format("there are more than {} channels", kMostMcapChannels));
    }
    const auto schema = schemas_.find(content.number<std::uint16_t>());
    McapChannel& channel = channels_[id];
    channel.topic = content.name();
    channel.encoding = content.name();
    if (schema != schemas_.end()) channel.schema = schema->second;
  }

  void on_metadata(McapContentReader& content) {
    const std::string name = content.name();
    McapContentReader pairs(content.text(), content.place());
    std::map<std::string, std::string> facts;
    while (!pairs.rest().empty()) {
      if (facts.size() == kMostMcapFacts) {
        pairs.fail(fmt::format("metadata of more than {} facts", kMostMcapFacts));
      }
      std::string key = pairs.name();
      facts[std::move(key)] = pairs.text();
    }
    listener_.on_metadata(name, facts);
  }

  void on_chunk(McapContentReader& content, const McapRecord& record) {
    content.number<std::uint64_t>();  // times
    content.number<std::uint64_t>();
    const auto size = content.number<std::uint64_t>();
    const auto crc = content.number<std::uint32_t>();
    const std::string compression = content.name();
    const std::string_view stored = content.bytes(content.number<std::uint64_t>());
    if (size > kMostMcapChunkBytes) {
      content.fail(fmt::format("a chunk of {} bytes, and at most 256 MiB are read", size));
    }
    all_bytes_ += size;
    if (all_bytes_ > kMostMcapBytes) content.fail("the chunks have more than 4 GiB");
    std::string_view records = stored;
    if (compression == "zstd") {
      records = decompressed(stored, size, content);
    } else if (!compression.empty()) {
      content.fail(fmt::format("a chunk compressed with `{}`; zstd and none are read",
                               base::printable(compression)));
    }
    if (records.size() != size) {
      content.fail(fmt::format("a chunk of {} bytes that says it has {}", records.size(), size));
    }
    if (crc != 0 && mcap_crc_of(records) != crc)
      content.fail("the chunk does not have its checksum");
    for (std::size_t at = 0; at < records.size();) {
      const auto inner = mcap_record_at(records, at);
      if (!inner) {
        content.fail(fmt::format("the chunk ends within the record at its byte {}", at));
      }
      McapContentReader own(
          inner->content, fmt::format("byte {}, in the chunk there at byte {}", record.place, at));
      on_content(inner->opcode, own);
      at = inner->end;
    }
  }

  std::string_view decompressed(std::string_view stored, std::uint64_t size,
                                const McapContentReader& content) {
    chunk_.resize(size);
    const std::size_t got =
        ZSTD_decompress(chunk_.data(), chunk_.size(), stored.data(), stored.size());
    if (ZSTD_isError(got) != 0) {
      content.fail(fmt::format("the chunk is not what zstd wrote: {}", ZSTD_getErrorName(got)));
    }
    return std::string_view(chunk_).substr(0, got);
  }

  std::string_view bytes_;
  McapListener& listener_;
  std::unordered_map<std::uint16_t, std::string> schemas_;
  std::unordered_map<std::uint16_t, McapChannel> channels_;
  std::string chunk_;
  std::uint64_t all_bytes_ = 0;
  bool in_summary_ = false;
};

}  // namespace

std::optional<std::size_t> read_mcap(std::string_view bytes, McapListener& listener) {
  return McapReader(bytes, listener).read();
}

}  // namespace cas::hils
