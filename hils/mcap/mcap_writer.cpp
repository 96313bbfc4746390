// SPDX-License-Identifier: BSD-3-Clause
#include "hils/mcap/mcap_writer.hpp"

#include <zlib.h>
#include <zstd.h>

#include <algorithm>
#include <cstdio>
#include <span>

#include "base/error.hpp"

namespace cas::hils {

namespace {

/// Fast, and as small as what a slower level gives within some percent.
constexpr int kMcapZstdLevel = 3;

void free_zstd(ZSTD_CCtx_s* context) { ZSTD_freeCCtx(context); }

std::uint32_t mcap_crc(std::string_view bytes, std::uint32_t before = 0) {
  return static_cast<std::uint32_t>(::crc32_z(before, reinterpret_cast<const Bytef*>(bytes.data()),
                                              static_cast<z_size_t>(bytes.size())));
}

/// The content of a record, field by field.
class McapFields {
 public:
  template <class T>
  McapFields& number(T value) {
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof value);
    return *this;
  }
  /// With its length before it, as text, arrays and maps are.
  McapFields& text(std::string_view value) {
    return number(static_cast<std::uint32_t>(value.size())).bytes(value);
  }
  McapFields& bytes(std::string_view value) {
    bytes_ += value;
    return *this;
  }
  const std::string& done() const { return bytes_; }

 private:
  std::string bytes_;
};

void append_mcap_record(std::string& to, McapOpcode opcode, std::string_view content) {
  to += static_cast<char>(opcode);
  const std::uint64_t length = content.size();
  to.append(reinterpret_cast<const char*>(&length), sizeof length);
  to += content;
}

}  // namespace

void McapWriter::Span::add(std::uint64_t time_ns) {
  first_ns = messages == 0 ? time_ns : std::min(first_ns, time_ns);
  last_ns = std::max(last_ns, time_ns);
  ++messages;
}

McapWriter::McapWriter(base::ResultPlace place, std::string_view library, std::size_t chunk_bytes)
    : place_(std::move(place)),
      file_(base::open_result(place_)),
      chunk_bytes_(chunk_bytes),
      zstd_(ZSTD_createCCtx(), free_zstd) {
  CAS_CHECK(zstd_ != nullptr);
  put(kMcapMagic);
  put_record(McapOpcode::kHeader, McapFields().text("").text(library).done());
}

McapWriter::~McapWriter() = default;

std::uint16_t McapWriter::add_schema(std::string_view name, std::string_view text) {
  const auto id = static_cast<std::uint16_t>(schemas_.size() + 1);
  Declared& added = schemas_.emplace_back();
  append_mcap_record(added.record, McapOpcode::kSchema,
                     McapFields().number(id).text(name).text("jsonschema").text(text).done());
  return id;
}

std::uint16_t McapWriter::add_channel(std::uint16_t schema, std::string_view topic) {
  CAS_CHECK(schema >= 1 && schema <= schemas_.size());
  const auto id = static_cast<std::uint16_t>(channels_.size() + 1);
  Declared& added = channels_.emplace_back();
  added.schema = schema;
  append_mcap_record(
      added.record, McapOpcode::kChannel,
      McapFields().number(id).number(schema).text(topic).text("json").text("").done());
  return id;
}

void McapWriter::write(std::uint16_t channel, base::SimTime time, std::string_view json) {
  CAS_CHECK(channel >= 1 && channel <= channels_.size());
  Declared& own = channels_[channel - 1U];
  std::string declarations;
  for (Declared* declared : {&schemas_[own.schema - 1U], &own}) {
    if (!declared->written) declarations += declared->record;
    declared->written = true;
  }
  const std::size_t size = declarations.size() + kMcapRecordHead + kMcapMessageHead + json.size();
  if (chunk_span_.messages > 0 && chunk_.size() + size > chunk_bytes_) write_chunk();
  chunk_ += declarations;
  const auto time_ns = static_cast<std::uint64_t>(time.time_since_epoch().count());
  index_[channel].emplace_back(time_ns, chunk_.size());
  append_mcap_record(chunk_, McapOpcode::kMessage,
                     McapFields()
                         .number(channel)
                         .number(own.messages++)
                         .number(time_ns)
                         .number(time_ns)
                         .bytes(json)
                         .done());
  chunk_span_.add(time_ns);
  all_.add(time_ns);
}

void McapWriter::write_metadata(std::string_view name,
                                const std::map<std::string, std::string>& facts) {
  McapFields pairs;
  for (const auto& [key, value] : facts) pairs.text(key).text(value);
  const std::uint64_t begin = offset_;
  put_record(McapOpcode::kMetadata, McapFields().text(name).text(pairs.done()).done());
  metadata_indexes_.push_back(McapFields().number(begin).number(offset_ - begin).text(name).done());
}

void McapWriter::write_chunk() {
  compressed_.resize(ZSTD_compressBound(chunk_.size()));
  const std::size_t size = ZSTD_compressCCtx(zstd_.get(), compressed_.data(), compressed_.size(),
                                             chunk_.data(), chunk_.size(), kMcapZstdLevel);
  if (ZSTD_isError(size) != 0) {
    throw base::ConfigError(place_.path().string() +
                            ": zstd cannot compress a chunk: " + ZSTD_getErrorName(size));
  }
  compressed_.resize(size);
  const std::uint64_t begin = offset_;
  put_record(McapOpcode::kChunk, McapFields()
                                     .number(chunk_span_.first_ns)
                                     .number(chunk_span_.last_ns)
                                     .number(std::uint64_t{chunk_.size()})
                                     .number(mcap_crc(chunk_))
                                     .text("zstd")
                                     .number(std::uint64_t{size})
                                     .bytes(compressed_)
                                     .done());
  const std::uint64_t end = offset_;
  McapFields places;
  for (const auto& [channel, messages] : index_) {
    places.number(channel).number(offset_);
    McapFields entries;
    for (const auto& [time_ns, place] : messages) entries.number(time_ns).number(place);
    put_record(McapOpcode::kMessageIndex, McapFields().number(channel).text(entries.done()).done());
  }
  chunk_indexes_.push_back(McapFields()
                               .number(chunk_span_.first_ns)
                               .number(chunk_span_.last_ns)
                               .number(begin)
                               .number(end - begin)
                               .text(places.done())
                               .number(offset_ - end)
                               .text("zstd")
                               .number(std::uint64_t{size})
                               .number(std::uint64_t{chunk_.size()})
                               .done());
  chunk_.clear();
  index_.clear();
  chunk_span_ = {};
}

void McapWriter::close() {
  if (chunk_span_.messages > 0) write_chunk();
  put_record(McapOpcode::kDataEnd, McapFields().number(crc_).done());
  write_summary();
  put(kMcapMagic);
  base::close_result(std::move(file_), place_);
}

void McapWriter::write_summary() {
  const std::uint64_t begin = offset_;
  crc_ = 0;
  McapFields offsets;
  const auto group = [&](McapOpcode opcode, auto&& write) {
    const std::uint64_t start = offset_;
    write();
    if (offset_ == start) return;
    std::string record;
    append_mcap_record(record, McapOpcode::kSummaryOffset,
                       McapFields().number(opcode).number(start).number(offset_ - start).done());
    offsets.bytes(record);
  };
  const auto count = [](std::span<const Declared> all) {
    return std::ranges::count_if(all, &Declared::written);
  };
  const auto put_written = [&](std::span<const Declared> all) {
    for (const Declared& each : all) {
      if (each.written) put(each.record);
    }
  };
  group(McapOpcode::kSchema, [&] { put_written(schemas_); });
  group(McapOpcode::kChannel, [&] { put_written(channels_); });
  group(McapOpcode::kStatistics, [&] {
    McapFields counts;
    for (std::size_t i = 0; i < channels_.size(); ++i) {
      if (!channels_[i].written) continue;
      counts.number(static_cast<std::uint16_t>(i + 1)).number(std::uint64_t{channels_[i].messages});
    }
    put_record(McapOpcode::kStatistics,
               McapFields()
                   .number(all_.messages)
                   .number(static_cast<std::uint16_t>(count(schemas_)))
                   .number(static_cast<std::uint32_t>(count(channels_)))
                   .number(std::uint32_t{0})  // attachments
                   .number(static_cast<std::uint32_t>(metadata_indexes_.size()))
                   .number(static_cast<std::uint32_t>(chunk_indexes_.size()))
                   .number(all_.first_ns)
                   .number(all_.last_ns)
                   .text(counts.done())
                   .done());
  });
  group(McapOpcode::kChunkIndex, [&] {
    for (const std::string& index : chunk_indexes_) put_record(McapOpcode::kChunkIndex, index);
  });
  group(McapOpcode::kMetadataIndex, [&] {
    for (const std::string& index : metadata_indexes_) {
      put_record(McapOpcode::kMetadataIndex, index);
    }
  });
  const std::uint64_t offsets_begin = offset_;
  put(offsets.done());
  constexpr std::uint64_t kFooterBytes = 20;
  // The checksum ends before itself: in the footer's record.
  put(McapFields()
          .number(McapOpcode::kFooter)
          .number(kFooterBytes)
          .number(begin)
          .number(offsets_begin)
          .done());
  put(McapFields().number(crc_).done());
}

void McapWriter::put(std::string_view bytes) {
  std::fwrite(bytes.data(), 1, bytes.size(), file_.get());  // close() tells when some are missing
  crc_ = mcap_crc(bytes, crc_);
  offset_ += bytes.size();
}

void McapWriter::put_record(McapOpcode opcode, std::string_view content) {
  McapFields head;
  head.number(opcode).number(std::uint64_t{content.size()});
  put(head.done());
  put(content);
}

}  // namespace cas::hils
