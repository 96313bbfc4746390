// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "libsim/api/messages.hpp"

/// Payloads of UBX messages, protocol version 27 (u-blox F9 Interface Description): little endian,
/// fields at fixed offsets.
namespace cas::sim {

/// Leap seconds between GPS time and UTC since 2017 [IERS Bulletin C].
inline constexpr int kLeapSeconds = 18;

/// What a receiver tells about one moment.
struct UbxEpoch {
  std::uint64_t gps_ns = 0;  ///< since 6 January 1980, GPS time
  GpsSample fix;
  double speed_accuracy_m_s = 0.1;
  /// From the first antenna to the second, north, east, down, m; nullopt: there is one.
  std::optional<Eigen::Vector3d> baseline_N{};
  double heading_accuracy_rad = 0;
};

using UbxPayload = std::vector<std::uint8_t>;

/// Time, fix, place (the height above the ellipsoid is given as that above sea level), velocity and
/// accuracies. Without a fix place and velocity are 0.
UbxPayload nav_pvt(const UbxEpoch& epoch);
/// All dilutions are those of as many satellites spread well: sqrt(10 / satellites).
UbxPayload nav_dop(const UbxEpoch& epoch);
/// Week and time of week.
UbxPayload nav_time_gps(const UbxEpoch& epoch);
/// Satellites of GPS with their C/N0; elevation and azimuth are made up, evenly spread.
UbxPayload nav_sat(const UbxEpoch& epoch);
/// The baseline between two antennas, fixed, with its heading. Only with one.
UbxPayload nav_rel_pos_ned(const UbxEpoch& epoch);
/// A ZED-F9P of protocol 27.31.
UbxPayload mon_ver();
/// Indicator and state of jamming by the fall of C/N0 below 44 dB-Hz.
UbxPayload mon_rf(const UbxEpoch& epoch);

}  // namespace cas::sim
