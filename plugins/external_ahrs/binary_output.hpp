// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/earth/geodesy.hpp"

namespace cas::sim {

/// The attitude, place and velocity that the unit computes, in N and D.
struct UnitSolution {
  Eigen::Quaterniond q_ND = Eigen::Quaterniond::Identity();
  base::Geodetic position;                               ///< altitude above mean sea level
  Eigen::Vector3d velocity_N = Eigen::Vector3d::Zero();  ///< m/s
  double attitude_sigma_deg = 0;
  double position_sigma_m = 0;
  double velocity_sigma_m_s = 0;
};

/// The receiver's newest fix.
struct UnitFix {
  std::uint8_t type = 0;  ///< by VectorNav: 0 none, 2 2D, 3 3D, 4 SBAS, 7 RTK float, 8 RTK fixed
  std::uint8_t satellites = 0;
  base::Geodetic position;                               ///< altitude above mean sea level
  Eigen::Vector3d velocity_N = Eigen::Vector3d::Zero();  ///< m/s
  double horizontal_sigma_m = 0;
  double vertical_sigma_m = 0;
  double velocity_sigma_m_s = 0;
};

/// What the unit knows when it builds a packet; forward-right-down, SI.
struct UnitReadings {
  std::uint64_t startup_ns = 0;                       ///< since the unit's start
  std::uint64_t gps_ns = 0;                           ///< since 6 January 1980, GPS time
  Eigen::Vector3d accel_D = Eigen::Vector3d::Zero();  ///< specific force, m/s^2
  Eigen::Vector3d gyro_D = Eigen::Vector3d::Zero();   ///< rad/s
  Eigen::Vector3d field_D = Eigen::Vector3d::Zero();  ///< gauss
  double temperature_degc = 0;
  double pressure_pa = 0;
  UnitSolution solution;
  UnitFix fix;
  bool has_second_receiver = false;  ///< VN-300
};

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
