// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>

namespace cas::hils {

/// A stream of messages of one kind.
struct McapChannel {
  std::string topic;
  std::string encoding;  ///< of its messages: json, cdr, protobuf
  std::string schema;    ///< its name; empty: none
};

/// Receives the contents of a file in their order from read_mcap(). The replay collects its page
/// with one.
class McapListener {
 public:
  virtual ~McapListener() = default;

  virtual void on_metadata(std::string_view /*name*/,
                           const std::map<std::string, std::string>& /*facts*/) {}
  /// @param time_ns  of the log, from an origin of the file's own
  virtual void on_message(const McapChannel& /*channel*/, std::uint64_t /*time_ns*/,
                          std::string_view /*data*/) {}
};

/// Reads the messages of an MCAP file (mcap.dev/spec, version 0) from its begin to its end, with
/// chunks that are not compressed or by Zstandard. Its index is not needed; every checksum that it
/// has is compared. Records of kinds that are not known are skipped, and attachments.
///
/// Bounds: 256 MiB in a chunk, 4 GiB in all chunks (uncompressed), 10,000 channels, 1024 bytes in a
/// name, 1000 facts in a metadata record.
/// @return the place of the record that is not whole in a truncated file, which is read up to
///         there; nullopt: the file is whole
/// @throws base::ConfigError "byte 1234: ..." if it is no such file or is broken
std::optional<std::size_t> read_mcap(std::string_view bytes, McapListener& listener);

}  // namespace cas::hils
