// SPDX-License-Identifier: BSD-3-Clause
#include "mavlink_gen/services/px4_event.hpp"

#include <algorithm>
#include <iterator>

namespace cas::mav::services {
namespace {

constexpr std::uint32_t id_of(std::string_view name) {
  constexpr std::uint32_t kPx4 = 1U << 24;
  std::uint32_t hash = 0x811C9DC5;
  for (const char letter : name) hash = (hash ^ static_cast<std::uint8_t>(letter)) * 0x01000193U;
  return kPx4 | (hash & 0xFFFFFFU);
}

struct Check {
  std::uint32_t id;
  std::string_view words;
};

constexpr Check kChecks[] = {
    {id_of("check_accel_missing"), "no accelerometer"},
    {id_of("check_accel_no_data"), "the accelerometer sends nothing"},
    {id_of("check_gyro_missing"), "no gyroscope"},
    {id_of("check_gyro_no_data"), "the gyroscope sends nothing"},
    {id_of("check_baro_missing"), "no barometer"},
    {id_of("check_baro_no_data"), "the barometer sends nothing"},
    {id_of("check_mag_missing"), "no magnetometer"},
    {id_of("check_mag_sys_has_mag_missing"), "no magnetometer"},
    {id_of("check_mag_no_data"), "the magnetometer sends nothing"},
    {id_of("check_mag_fault"), "magnetometer fault"},
    {id_of("check_mag_consistency"), "the magnetometers disagree"},
    {id_of("check_imu_accel_inconsistent"), "the accelerometers disagree"},
    {id_of("check_imu_gyro_inconsistent"), "the gyroscopes disagree"},
    {id_of("check_estimator_missing_data"), "the estimator gets no data"},
    {id_of("check_estimator_mag_interference"), "strong magnetic interference"},
    {id_of("check_estimator_mag_fault"), "the estimator does not trust the magnetometer"},
    {id_of("check_estimator_gps_not_fusing"), "the estimator does not use the GPS"},
    {id_of("check_estimator_gps_fix_too_low"), "the GPS fix is too poor"},
    {id_of("check_estimator_gps_num_sats_too_low"), "too few GPS satellites"},
    {id_of("check_estimator_gps_pdop_too_high"), "the GPS satellites stand badly (PDOP)"},
    {id_of("check_estimator_gps_hor_pos_err_too_high"), "the GPS position is not accurate enough"},
    {id_of("check_estimator_gps_vert_pos_err_too_high"), "the GPS height is not accurate enough"},
    {id_of("check_estimator_gps_speed_acc_too_low"), "the GPS velocity is not accurate enough"},
    {id_of("check_estimator_gps_hor_pos_drift_too_high"), "the GPS position drifts"},
    {id_of("check_estimator_gps_vert_pos_drift_too_high"), "the GPS height drifts"},
    {id_of("check_estimator_gps_hor_speed_drift_too_high"), "the GPS speed is not zero at rest"},
    {id_of("check_estimator_gps_vert_speed_drift_too_high"),
     "the vertical GPS speed is not zero at rest"},
    {id_of("check_estimator_high_accel_bias"), "high accelerometer bias"},
    {id_of("check_estimator_high_gyro_bias"), "high gyroscope bias"},
    {id_of("check_estimator_heading_not_stable"), "the estimated heading is not stable"},
    {id_of("check_estimator_hor_vel_not_stable"), "the estimated velocity is not stable"},
    {id_of("check_estimator_vert_vel_not_stable"), "the estimated climb is not stable"},
    {id_of("check_estimator_hor_pos_not_stable"), "the estimated position is not stable"},
    {id_of("check_estimator_hgt_not_stable"), "the estimated height is not stable"},
};

}  // namespace

std::optional<std::uint32_t> event_id(const PacketView& packet) {
  if (packet.message_id != kEventMessage) return std::nullopt;
  std::uint32_t id = 0;
  for (std::size_t i = 0; i < 4 && i < packet.payload.size(); ++i) {
    id |= std::uint32_t{packet.payload[i]} << (8 * i);
  }
  return id;
}

bool begins_check_list(std::uint32_t id) { return id == id_of("commander_arming_check_summary"); }

std::string_view failed_check(std::uint32_t id) {
  const auto* const check = std::ranges::find(kChecks, id, &Check::id);
  return check == std::end(kChecks) ? std::string_view() : check->words;
}

}  // namespace cas::mav::services
