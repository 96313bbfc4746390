// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "plugins/external_ahrs/unit_readings.hpp"

namespace cas::sim {

/// CRC-16 of VectorNav's binary packets: polynomial 0x1021, initial value 0, no reflection. Over a
/// packet with its own CRC (high byte first) it is 0.
std::uint16_t vector_nav_crc(std::span<const std::uint8_t> bytes);

/// One of the unit's binary output registers 75 to 77, as its user has written it: which groups and
/// fields a packet carries, and how often. The packet follows from the masks alone:
///
///   0xFA, byte of groups, a 16-bit mask of fields for each group, fields in the order of the
///   groups' and fields' bits, CRC. Little-endian, but for the CRC.
///
/// Groups 0 (common), 1 (time), 2 (IMU), 3 (receiver), 4 (attitude), 5 (INS) and 6 (second
/// receiver), with the fields that a simulation has values for.
class BinaryOutput {
 public:
  static constexpr std::size_t kGroups = 7;

  /// Reads the words behind the register's number: port mask, divisor, groups (hex), a mask (hex)
  /// for each group: {"3", "2", "01", "0721"}.
  /// @param problem  in words, when it returns false: the register keeps its old value
  bool write(std::span<const std::string_view> words, std::string& problem);

  /// Whether it is sent at all: a port and a field are chosen.
  bool on() const { return ports_ != 0 && groups_ != 0; }
  /// Rate by the unit's own, Hz.
  double rate_hz(double base_hz) const { return on() ? base_hz / divisor_ : 0; }
  unsigned divisor() const { return divisor_; }
  /// Bytes of a packet, sync and CRC included.
  std::size_t packet_bytes() const;
  /// Whether it carries a sample of the inertial sensors, or a fix: then it waits for a new one.
  bool has_inertial() const;
  bool has_fix() const { return ((groups_ >> 3U | groups_ >> 6U) & 1U) != 0; }

  /// Replaces `packet`.
  void build(const UnitReadings& readings, std::vector<std::uint8_t>& packet) const;

 private:
  unsigned ports_ = 0;
  unsigned divisor_ = 1;
  std::uint8_t groups_ = 0;
  std::array<std::uint16_t, kGroups> fields_{};
};

}  // namespace cas::sim
