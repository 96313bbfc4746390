// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/os/result_file.hpp"
#include "base/time/clock.hpp"
#include "hils/mcap/mcap_format.hpp"

struct ZSTD_CCtx_s;

namespace cas::hils {

/// Writes an MCAP file (mcap.dev/spec): JSON messages in chunks compressed with Zstandard, each
/// followed by the index of its messages, then summary, statistics and checksums. A chunk is
/// written as soon as it is full: memory holds one chunk and the index of all.
class McapWriter {
 public:
  /// @param chunk_bytes  of the messages of a chunk, uncompressed; a larger message has one alone
  /// @throws base::ConfigError when the file cannot be made
  explicit McapWriter(base::ResultPlace place, std::string_view library,
                      std::size_t chunk_bytes = std::size_t{1} << 20U);
  ~McapWriter();

  /// @param text  JSON Schema
  /// @return its id
  std::uint16_t add_schema(std::string_view name, std::string_view text);
  /// A channel of JSON messages; the file has it once it has a message.
  /// @return its id
  std::uint16_t add_channel(std::uint16_t schema, std::string_view topic);
  /// @param json  one value
  void write(std::uint16_t channel, base::SimTime time, std::string_view json);
  /// Facts of the whole file. Before the first message.
  void write_metadata(std::string_view name, const std::map<std::string, std::string>& facts);
  /// Writes what is left, and the summary. @throws base::DiskError when the file lacks bytes
  void close();

 private:
  /// A schema or channel as its record, and whether that has been written.
  struct Declared {
    std::string record;
    bool written = false;
    std::uint16_t schema = 0;    ///< of a channel
    std::uint32_t messages = 0;  ///< of a channel
  };
  struct Span {
    std::uint64_t first_ns = 0;
    std::uint64_t last_ns = 0;
    std::uint64_t messages = 0;

    void add(std::uint64_t time_ns);
  };
  /// Time and place of each message of a channel in the chunk.
  using Index = std::map<std::uint16_t, std::vector<std::pair<std::uint64_t, std::uint64_t>>>;

  void write_chunk();
  void write_summary();
  void put(std::string_view bytes);
  void put_record(McapOpcode opcode, std::string_view content);

  base::ResultPlace place_;
  base::OpenFile file_;
  std::size_t chunk_bytes_;
  std::unique_ptr<ZSTD_CCtx_s, void (*)(ZSTD_CCtx_s*)> zstd_;
  std::vector<Declared> schemas_;   ///< id 1 first
  std::vector<Declared> channels_;  ///< likewise
  std::string chunk_;               ///< records, uncompressed
  Span chunk_span_;
  Index index_;
  std::string compressed_;
  std::vector<std::string> chunk_indexes_;     ///< contents of records of the summary
  std::vector<std::string> metadata_indexes_;  ///< likewise
  Span all_;
  std::uint64_t offset_ = 0;
  std::uint32_t crc_ = 0;  ///< of the file so far, or of the summary
};

}  // namespace cas::hils
