// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <zstd.h>

#include <cstdint>
#include <string>
#include <string_view>

namespace cas::test {

/// CRC-32 of IEEE 802.3, bit by bit: what MCAP's checksums are.
inline std::uint32_t mcap_crc32(std::string_view bytes) {
  std::uint32_t crc = 0xFFFFFFFF;
  for (const char c : bytes) {
    crc ^= static_cast<std::uint8_t>(c);
    for (int bit = 0; bit < 8; ++bit) crc = crc >> 1U ^ ((crc & 1U) != 0 ? 0xEDB88320U : 0U);
  }
  return ~crc;
}

/// As a chunk has it, at the level of our writer.
inline std::string mcap_compressed(std::string_view bytes) {
  std::string to(ZSTD_compressBound(bytes.size()), '\0');
  to.resize(ZSTD_compress(to.data(), to.size(), bytes.data(), bytes.size(), 3));
  return to;
}

/// An MCAP that is written record by record by the rules of mcap.dev/spec, so that a test can break
/// each by itself.
class McapBytes {
 public:
  static constexpr std::string_view kMagic{"\x89MCAP0\r\n", 8};

  McapBytes() : bytes_(kMagic) { bytes_ += record(0x01, text("") + text("a test")); }
  /// Of records alone: the contents of a chunk.
  static McapBytes of_records() {
    McapBytes bytes;
    bytes.bytes_.clear();
    return bytes;
  }

  template <class T>
  static std::string number(T value) {
    return {reinterpret_cast<const char*>(&value), sizeof value};
  }
  static std::string text(std::string_view value) {
    return number(static_cast<std::uint32_t>(value.size())).append(value);
  }
  static std::string record(int opcode, std::string_view content) {
    return static_cast<char>(opcode) + number(std::uint64_t{content.size()}).append(content);
  }

  McapBytes& add(int opcode, std::string_view content) {
    bytes_ += record(opcode, content);
    return *this;
  }
  McapBytes& schema(std::uint16_t id, std::string_view name, std::string_view json = "{}") {
    return add(0x03, number(id) + text(name) + text("jsonschema") + text(json));
  }
  McapBytes& channel(std::uint16_t id, std::uint16_t schema, std::string_view topic,
                     std::string_view encoding = "json") {
    return add(0x04, number(id) + number(schema) + text(topic) + text(encoding) + text(""));
  }
  McapBytes& message(std::uint16_t channel, std::uint64_t time_ns, std::string_view data,
                     std::uint32_t sequence = 0) {
    return add(0x05, number(channel) + number(sequence) + number(time_ns) + number(time_ns) +
                         std::string(data));
  }
  /// @param stored  as it is in the file
  McapBytes& chunk(std::string_view compression, std::string_view stored, std::uint64_t size,
                   std::uint32_t crc) {
    return add(0x06, number(std::uint64_t{0}) + number(std::uint64_t{0}) + number(size) +
                         number(crc) + text(compression) + number(std::uint64_t{stored.size()}) +
                         std::string(stored));
  }
  /// Ends the data, without a summary.
  std::string whole() const {
    return bytes_ + record(0x0F, number(std::uint32_t{0})) +
           record(0x02,
                  number(std::uint64_t{0}) + number(std::uint64_t{0}) + number(std::uint32_t{0})) +
           std::string(kMagic);
  }
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

}  // namespace cas::test
