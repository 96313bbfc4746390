// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/external_ahrs/binary_output.hpp"

#include <fmt/format.h>
#include <bit>
#include <charconv>
#include <cmath>
#include <optional>

#include "base/angles.hpp"
#include "base/earth/frames.hpp"

namespace cas::sim {
namespace {

constexpr std::uint8_t kSync = 0xFA;
constexpr unsigned kMostDivisor = 65'535;

/// Appends values in the order of the wire: little-endian.
class PacketWriter {
 public:
  explicit PacketWriter(std::vector<std::uint8_t>& bytes) : bytes_(bytes) {}

  template <class Whole>
  void whole(Whole value) {
    for (std::size_t i = 0; i < sizeof value; ++i) {
      bytes_.push_back(static_cast<std::uint8_t>(value >> 8U * i));
    }
  }
  void real32(double value) { whole(std::bit_cast<std::uint32_t>(static_cast<float>(value))); }
  void real64(double value) { whole(std::bit_cast<std::uint64_t>(value)); }
  void vector(const Eigen::Vector3d& v) {
    for (int i = 0; i < 3; ++i) real32(v[i]);
  }
  void place(const base::Geodetic& place) {
    real64(place.lat_deg);
    real64(place.lon_deg);
    real64(place.alt_m);
  }

 private:
  std::vector<std::uint8_t>& bytes_;
};

using Readings = UnitReadings;
/// Writes one field; nullptr: the simulation has no value for it.
using Field = void (*)(const Readings&, PacketWriter&);
using Fields = std::array<Field, 15>;

constexpr std::uint64_t kWeek_ns = 7ULL * 24 * 3600 * 1'000'000'000;
constexpr double kKilopascal = 1000;

void startup(const Readings& r, PacketWriter& out) { out.whole(r.startup_ns); }
void gps_time(const Readings& r, PacketWriter& out) { out.whole(r.gps_ns); }
void gps_tow(const Readings& r, PacketWriter& out) { out.whole(r.gps_ns % kWeek_ns); }
void gps_week(const Readings& r, PacketWriter& out) {
  out.whole(static_cast<std::uint16_t>(r.gps_ns / kWeek_ns));
}
void accel(const Readings& r, PacketWriter& out) { out.vector(r.accel_D); }
void gyro(const Readings& r, PacketWriter& out) { out.vector(r.gyro_D); }
void field(const Readings& r, PacketWriter& out) { out.vector(r.field_D); }
void temperature(const Readings& r, PacketWriter& out) { out.real32(r.temperature_degc); }
void pressure(const Readings& r, PacketWriter& out) { out.real32(r.pressure_pa / kKilopascal); }
void accel_gyro(const Readings& r, PacketWriter& out) {
  accel(r, out);
  gyro(r, out);
}
void field_air(const Readings& r, PacketWriter& out) {
  field(r, out);
  temperature(r, out);
  pressure(r, out);
}

void yaw_pitch_roll(const Readings& r, PacketWriter& out) {
  const Eigen::Vector3d rpy = base::euler_rpy(r.solution.q_ND);
  for (const int i : {2, 1, 0}) out.real32(base::degrees(rpy[i]));
}
void quaternion(const Readings& r, PacketWriter& out) {
  const Eigen::Quaterniond& q = r.solution.q_ND;
  for (const double part : {q.x(), q.y(), q.z(), q.w()}) out.real32(part);
}
void attitude_sigma(const Readings& r, PacketWriter& out) {
  for (int i = 0; i < 3; ++i) out.real32(r.solution.attitude_sigma_deg);
}
/// Bits 0 and 1: 2 tracks, 1 aligns; bit 2: the receiver has a fix.
void ins_status(const Readings& r, PacketWriter& out) {
  constexpr unsigned kTracks = 2;
  constexpr unsigned kAligns = 1;
  constexpr unsigned kHasFix = 4;
  out.whole(static_cast<std::uint16_t>(r.fix.type >= 3 ? kTracks | kHasFix : kAligns));
}
void place(const Readings& r, PacketWriter& out) { out.place(r.solution.position); }
void velocity(const Readings& r, PacketWriter& out) { out.vector(r.solution.velocity_N); }
void place_sigma(const Readings& r, PacketWriter& out) { out.real32(r.solution.position_sigma_m); }
void velocity_sigma(const Readings& r, PacketWriter& out) {
  out.real32(r.solution.velocity_sigma_m_s);
}

void satellites(const Readings& r, PacketWriter& out) { out.whole(r.fix.satellites); }
void fix_type(const Readings& r, PacketWriter& out) { out.whole(r.fix.type); }
void satellites_2(const Readings& r, PacketWriter& out) {
  out.whole(r.has_second_receiver ? r.fix.satellites : std::uint8_t{0});
}
void fix_type_2(const Readings& r, PacketWriter& out) {
  out.whole(r.has_second_receiver ? r.fix.type : std::uint8_t{0});
}
void fix_place(const Readings& r, PacketWriter& out) { out.place(r.fix.position); }
void fix_velocity(const Readings& r, PacketWriter& out) { out.vector(r.fix.velocity_N); }
void fix_sigma(const Readings& r, PacketWriter& out) {
  const double each_m = r.fix.horizontal_sigma_m;
  out.vector({each_m, each_m, r.fix.vertical_sigma_m});
}
void fix_velocity_sigma(const Readings& r, PacketWriter& out) {
  out.real32(r.fix.velocity_sigma_m_s);
}
/// Dilutions g, p, t, v, h, n, e of a receiver whose ranges are good to kRange_m.
void dilution(const Readings& r, PacketWriter& out) {
  constexpr double kRange_m = 1;
  const double h = r.fix.horizontal_sigma_m / kRange_m;
  const double v = r.fix.vertical_sigma_m / kRange_m;
  const double p = std::hypot(h, v);
  const double each = h / std::sqrt(2.0);
  for (const double dop : {p, p, 0.0, v, h, each, each}) out.real32(dop);
}

constexpr Field kNone = nullptr;
constexpr std::array<Fields, BinaryOutput::kGroups> kFields{{
    {startup, gps_time, kNone, yaw_pitch_roll, quaternion, gyro, place, velocity, accel, accel_gyro,
     field_air, kNone, ins_status, kNone, kNone},
    {startup, gps_time, gps_tow, gps_week},
    {kNone, field, accel, gyro, temperature, pressure, kNone, kNone, field, accel, gyro},
    {kNone, gps_tow, gps_week, satellites, fix_type, fix_place, kNone, fix_velocity, kNone,
     fix_sigma, fix_velocity_sigma, kNone, kNone, dilution},
    {kNone, yaw_pitch_roll, quaternion, kNone, kNone, kNone, kNone, kNone, attitude_sigma},
    {ins_status, place, kNone, kNone, velocity, kNone, kNone, kNone, kNone, place_sigma,
     velocity_sigma},
    {kNone, gps_tow, gps_week, satellites_2, fix_type_2, fix_place, kNone, fix_velocity, kNone,
     fix_sigma, fix_velocity_sigma, kNone, kNone, dilution},
}};

bool has(unsigned mask, std::size_t bit) { return (mask >> bit & 1U) != 0; }

template <class Whole>
std::optional<Whole> number(std::string_view word, int base) {
  Whole value{};
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value, base);
  if (error != std::errc() || end != word.data() + word.size()) return std::nullopt;
  return value;
}

/// The first field of a mask that the simulation has no value for.
std::optional<std::size_t> unknown_field(std::size_t group, std::uint16_t mask) {
  for (std::size_t bit = 0; bit < 16; ++bit) {
    const bool known = bit < kFields[group].size() && kFields[group][bit] != nullptr;
    if (has(mask, bit) && !known) return bit;
  }
  return std::nullopt;
}

}  // namespace

std::uint16_t vector_nav_crc(std::span<const std::uint8_t> bytes) {
  unsigned crc = 0;
  for (const std::uint8_t byte : bytes) {
    crc ^= static_cast<unsigned>(byte) << 8U;
    for (int bit = 0; bit < 8; ++bit) crc = (crc & 0x8000U) != 0 ? crc << 1U ^ 0x1021U : crc << 1U;
    crc &= 0xFFFFU;
  }
  return static_cast<std::uint16_t>(crc);
}

bool BinaryOutput::write(std::span<const std::string_view> words, std::string& problem) {
  const auto refuse = [&problem](std::string why) {
    problem = std::move(why);
    return false;
  };
  if (words.size() < 2) return refuse("it names no port and divisor");
  const auto ports = number<unsigned>(words[0], 10);
  const auto divisor = number<unsigned>(words[1], 10);
  const auto groups = words.size() > 2 ? number<std::uint8_t>(words[2], 16) : std::uint8_t{0};
  if (!ports || !divisor || !groups) return refuse("a word of it is no number");
  if (*ports > 3 || *divisor < 1 || *divisor > kMostDivisor) return refuse("out of range");
  BinaryOutput fresh;
  fresh.ports_ = *ports;
  fresh.divisor_ = *divisor;
  fresh.groups_ = *groups;
  std::size_t word = 3;
  for (std::size_t group = 0; group < 8; ++group) {
    if (!has(*groups, group)) continue;
    const auto mask = word < words.size() ? number<std::uint16_t>(words[word++], 16) : std::nullopt;
    if (!mask) return refuse(fmt::format("group {} has no mask of fields", group));
    if (group >= kGroups) return refuse(fmt::format("group {} is not simulated", group));
    if (const auto bit = unknown_field(group, *mask)) {
      return refuse(fmt::format("field {} of group {} is not simulated", *bit, group));
    }
    fresh.fields_[group] = *mask;
  }
  if (word < words.size()) return refuse("it has more masks than groups");
  *this = fresh;
  return true;
}

std::size_t BinaryOutput::packet_bytes() const {
  std::vector<std::uint8_t> packet;
  build({}, packet);
  return packet.size();
}

bool BinaryOutput::has_inertial() const {
  constexpr unsigned kCommon = 1U << 5U | 1U << 8U | 1U << 9U;
  constexpr unsigned kImu = 1U << 2U | 1U << 3U | 1U << 9U | 1U << 10U;
  return (fields_[0] & kCommon) != 0 || (fields_[2] & kImu) != 0;
}

void BinaryOutput::build(const UnitReadings& readings, std::vector<std::uint8_t>& packet) const {
  packet.clear();
  PacketWriter out(packet);
  out.whole(kSync);
  out.whole(groups_);
  for (std::size_t group = 0; group < kGroups; ++group) {
    if (has(groups_, group)) out.whole(fields_[group]);
  }
  for (std::size_t group = 0; group < kGroups; ++group) {
    for (std::size_t bit = 0; bit < kFields[group].size(); ++bit) {
      if (has(fields_[group], bit)) kFields[group][bit](readings, out);
    }
  }
  const std::uint16_t crc = vector_nav_crc(std::span(packet).subspan(1));
  out.whole(static_cast<std::uint8_t>(crc >> 8U));
  out.whole(static_cast<std::uint8_t>(crc & 0xFFU));
}

}  // namespace cas::sim
