// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "plugins/external_ahrs/binary_output.hpp"

namespace cas::test {

/// "$body*XX\r\n".
inline std::string nmea_line(std::string_view body) {
  unsigned sum = 0;
  for (const char c : body) sum ^= static_cast<unsigned char>(c);
  char end[8];
  std::snprintf(end, sizeof end, "*%02X\r\n", sum);
  return "$" + std::string(body) + end;
}

/// An autopilot's driver for a VectorNav, without a line: sends one line after the other, waits for
/// the answer to each, and then reads packets of known headers.
class VectorNavDriver {
 public:
  /// @param lines  bodies, one after the other
  /// @param packets  header behind the sync byte -> length of the whole packet
  VectorNavDriver(std::vector<std::string> lines,
                  std::map<std::vector<std::uint8_t>, std::size_t> packets)
      : lines_(std::move(lines)), packets_(std::move(packets)) {}

  /// What to send now; empty: an answer is awaited, or the handshake is done.
  std::string to_send() {
    if (done() || waiting_) return {};
    waiting_ = true;
    return nmea_line(lines_[next_]);
  }
  bool done() const { return next_ == lines_.size(); }

  void feed(std::span<const std::uint8_t> bytes) {
    bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
    while (done() ? take_packet() : take_answer()) {
    }
  }

  std::vector<std::string> answers;
  std::map<std::size_t, std::vector<std::vector<std::uint8_t>>> received;  ///< by length
  std::size_t bad = 0;  ///< bytes that belong to no packet, or to one with a wrong CRC

 private:
  bool take_answer() {
    const auto end = std::find(bytes_.begin(), bytes_.end(), '\n');
    if (end == bytes_.end()) return false;
    const std::string line(bytes_.begin(), end + 1);
    bytes_.erase(bytes_.begin(), end + 1);
    answers.push_back(line);
    const std::string& asked = lines_[next_];
    if (line.compare(1, std::min<std::size_t>(asked.size(), 8), asked, 0, 8) != 0) return true;
    waiting_ = false;
    ++next_;
    return true;
  }

  bool take_packet() {
    if (bytes_.empty()) return false;
    for (const auto& [header, size] : packets_) {
      if (bytes_[0] != 0xFA || bytes_.size() < 1 + header.size()) continue;
      if (!std::equal(header.begin(), header.end(), bytes_.begin() + 1)) continue;
      if (bytes_.size() < size) return false;
      const std::vector<std::uint8_t> packet(bytes_.begin(),
                                             bytes_.begin() + static_cast<std::ptrdiff_t>(size));
      if (sim::vector_nav_crc(std::span(packet).subspan(1)) != 0) break;
      bytes_.erase(bytes_.begin(), bytes_.begin() + static_cast<std::ptrdiff_t>(size));
      received[size].push_back(packet);
      return true;
    }
    constexpr std::size_t kLongestHeader = 10;
    if (bytes_[0] == 0xFA && bytes_.size() < kLongestHeader) return false;
    bytes_.erase(bytes_.begin());
    ++bad;
    return true;
  }

  std::vector<std::string> lines_;
  std::map<std::vector<std::uint8_t>, std::size_t> packets_;
  std::size_t next_ = 0;
  bool waiting_ = false;
  std::vector<std::uint8_t> bytes_;
};

/// Of ArduCopter 4.6.2, for a VN-200: packets of 82 (inertial), 104 (solution) and 110 (fix) bytes.
inline VectorNavDriver arducopter_462() {
  return {{"VNASY,0", "VNWRG,06,0,1", "VNWRG,06,0,2", "VNRRG,01", "VNWRG,75,3,2,01,0721",
           "VNWRG,76,3,16,31,0001,0106,0613", "VNWRG,77,3,160,49,0003,26B8,0018", "VNASY,1"},
          {{{0x01, 0x21, 0x07}, 82},
           {{0x31, 0x01, 0x00, 0x06, 0x01, 0x13, 0x06}, 104},
           {{0x49, 0x03, 0x00, 0xB8, 0x26, 0x18, 0x00}, 110}}};
}

/// Of ArduCopter 4.5.7, for a VN-300.
inline VectorNavDriver arducopter_457() {
  return {{"VNASY,0", "VNRRG,01", "VNWRG,75,3,1,34,072E,0106,0612",
           "VNWRG,76,3,80,4E,0002,0010,20B8,0018", "VNASY,1"},
          {{{0x34, 0x2E, 0x07, 0x06, 0x01, 0x12, 0x06}, 170},
           {{0x4E, 0x02, 0x00, 0x10, 0x00, 0xB8, 0x20, 0x18, 0x00}, 92}}};
}

/// A number of a packet, little-endian.
template <class T>
T value_at(const std::vector<std::uint8_t>& packet, std::size_t at) {
  T value;
  std::memcpy(&value, packet.data() + at, sizeof value);
  return value;
}

}  // namespace cas::test
