// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/ubx/ubx_messages.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <iterator>
#include <limits>
#include <string_view>
#include <type_traits>
#include <utility>

#include "base/angles.hpp"
#include "plugins/common/satellite_signals.hpp"

namespace cas::sim {
namespace {

constexpr std::uint8_t kFix2d = 2;  // GPS_FIX_TYPE
constexpr std::uint64_t kNsPerMs = 1'000'000;
constexpr std::uint64_t kNsPerWeek = 604'800'000 * kNsPerMs;

/// Writes whole numbers little endian at an offset of a payload.
class Fields {
 public:
  explicit Fields(std::size_t size) : bytes_(size) {}

  template <std::integral Number>
  void put(std::size_t offset, Number value) {
    auto bits = static_cast<std::make_unsigned_t<Number>>(value);
    for (std::size_t i = 0; i < sizeof(Number); ++i) {
      bytes_[offset + i] = static_cast<std::uint8_t>(static_cast<std::uint64_t>(bits) >> (8 * i));
    }
  }
  /// The nearest whole number that the field can hold.
  template <std::integral Number>
  void put_rounded(std::size_t offset, double value) {
    const double least = static_cast<double>(std::numeric_limits<Number>::lowest());
    const double most = static_cast<double>(std::numeric_limits<Number>::max());
    const double held = std::isfinite(value) ? std::clamp(std::round(value), least, most) : 0.0;
    put(offset, static_cast<Number>(held));
  }
  void put_text(std::size_t offset, std::string_view text) {
    std::ranges::copy(text, bytes_.begin() + static_cast<std::ptrdiff_t>(offset));
  }
  UbxPayload take() { return std::move(bytes_); }

 private:
  UbxPayload bytes_;
};

std::uint32_t time_of_week_ms(const UbxEpoch& epoch) {
  return static_cast<std::uint32_t>(epoch.gps_ns % kNsPerWeek / kNsPerMs);
}

bool has_fix(const UbxEpoch& epoch) { return epoch.fix.fix_type >= kFix2d; }

double dilution(const UbxEpoch& epoch) {
  constexpr double kNone = 99.99;
  return epoch.fix.satellites > 0 ? std::sqrt(10.0 / epoch.fix.satellites) : kNone;
}

void put_utc(Fields& pvt, const UbxEpoch& epoch) {
  using namespace std::chrono;
  const auto since_1980 =
      nanoseconds(static_cast<std::int64_t>(epoch.gps_ns)) - seconds(kLeapSeconds);
  const auto whole = round<seconds>(since_1980);
  const sys_days begin = std::chrono::year(1980) / January / 6;
  const auto moment = begin + whole;
  const auto day = floor<days>(moment);
  const year_month_day date(day);
  const hh_mm_ss clock(moment - day);
  pvt.put(4, static_cast<std::uint16_t>(static_cast<int>(date.year())));
  pvt.put(6, static_cast<std::uint8_t>(static_cast<unsigned>(date.month())));
  pvt.put(7, static_cast<std::uint8_t>(static_cast<unsigned>(date.day())));
  pvt.put(8, static_cast<std::uint8_t>(clock.hours().count()));
  pvt.put(9, static_cast<std::uint8_t>(clock.minutes().count()));
  pvt.put(10, static_cast<std::uint8_t>(clock.seconds().count()));
  pvt.put(16, static_cast<std::int32_t>((since_1980 - whole).count()));
}

void put_solution(Fields& pvt, const GpsSample& fix) {
  constexpr double kMilli = 1e3;
  constexpr double kDeg5 = 1e5;
  const Eigen::Vector3d& v_N = fix.velocity_N;
  pvt.put_rounded<std::int32_t>(24, fix.position.lon_deg * 1e7);
  pvt.put_rounded<std::int32_t>(28, fix.position.lat_deg * 1e7);
  pvt.put_rounded<std::int32_t>(32, fix.position.alt_m * kMilli);
  pvt.put_rounded<std::int32_t>(36, fix.position.alt_m * kMilli);
  for (int i = 0; i < 3; ++i) {
    pvt.put_rounded<std::int32_t>(48 + 4 * static_cast<std::size_t>(i), v_N[i] * kMilli);
  }
  pvt.put_rounded<std::int32_t>(60, v_N.head<2>().norm() * kMilli);
  const double course = std::atan2(v_N.y(), v_N.x());
  pvt.put_rounded<std::int32_t>(
      64, (course < 0 ? course + 2 * M_PI : course) * base::kDegPerRad * kDeg5);
}

}  // namespace

UbxPayload nav_pvt(const UbxEpoch& epoch) {
  constexpr std::uint8_t kDateTimeResolved = 0x07;
  constexpr std::uint32_t kTimeAccuracy_ns = 30;
  const GpsSample& fix = epoch.fix;
  Fields pvt(92);
  pvt.put(0, time_of_week_ms(epoch));
  put_utc(pvt, epoch);
  pvt.put(11, kDateTimeResolved);
  pvt.put(12, kTimeAccuracy_ns);
  pvt.put(20,
          std::uint8_t{has_fix(epoch) ? std::min<std::uint8_t>(fix.fix_type, 3) : std::uint8_t{0}});
  pvt.put(21, std::uint8_t{has_fix(epoch) ? std::uint8_t{1} : std::uint8_t{0}});
  pvt.put(23, fix.satellites);
  pvt.put_rounded<std::uint32_t>(40, fix.eph_m * 1e3);
  pvt.put_rounded<std::uint32_t>(44, fix.epv_m * 1e3);
  pvt.put_rounded<std::uint32_t>(68, epoch.speed_accuracy_m_s * 1e3);
  pvt.put_rounded<std::uint32_t>(72, 180e5);
  pvt.put_rounded<std::uint16_t>(76, dilution(epoch) * 100);
  if (has_fix(epoch)) put_solution(pvt, fix);
  return pvt.take();
}

UbxPayload nav_dop(const UbxEpoch& epoch) {
  Fields dop(18);
  dop.put(0, time_of_week_ms(epoch));
  for (std::size_t offset = 4; offset < 18; offset += 2) {
    dop.put_rounded<std::uint16_t>(offset, dilution(epoch) * 100);
  }
  return dop.take();
}

UbxPayload nav_time_gps(const UbxEpoch& epoch) {
  constexpr std::uint8_t kAllValid = 0x07;
  Fields time(16);
  time.put(0, time_of_week_ms(epoch));
  time.put(4, static_cast<std::int32_t>(epoch.gps_ns % kNsPerMs));
  time.put(8, static_cast<std::int16_t>(epoch.gps_ns / kNsPerWeek));
  time.put(10, static_cast<std::int8_t>(kLeapSeconds));
  time.put(11, kAllValid);
  time.put(12, std::uint32_t{30});
  return time.take();
}

UbxPayload nav_sat(const UbxEpoch& epoch) {
  constexpr std::size_t kHead = 8;
  constexpr std::size_t kEach = 12;
  const std::size_t count = epoch.fix.satellites;
  Fields sat(kHead + kEach * count);
  sat.put(0, time_of_week_ms(epoch));
  sat.put(4, std::uint8_t{1});  // version
  sat.put(5, static_cast<std::uint8_t>(count));
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t at = kHead + kEach * i;
    const int index = static_cast<int>(i);
    const int all = static_cast<int>(count);
    constexpr std::uint32_t kUsedCodeAndCarrier = 0x0F;  // quality 7, used
    sat.put(at + 1, static_cast<std::uint8_t>(i + 1));
    sat.put_rounded<std::uint8_t>(at + 2, satellite_cn0_db_hz(epoch.fix.cn0_db_hz, index, all));
    sat.put(at + 3, static_cast<std::int8_t>(85 - 70 * index / all));
    sat.put(at + 4, static_cast<std::int16_t>(360 * index / all));
    sat.put(at + 8, kUsedCodeAndCarrier);
  }
  return sat.take();
}

UbxPayload nav_rel_pos_ned(const UbxEpoch& epoch) {
  constexpr std::uint32_t kFixedWithHeading = 0x001 | 0x002 | 0x004 | 0x010 | 0x100;
  const Eigen::Vector3d r_N = epoch.baseline_N.value_or(Eigen::Vector3d::Zero());
  Fields relative(64);
  relative.put(0, std::uint8_t{1});  // version
  relative.put(4, time_of_week_ms(epoch));
  const auto put_length = [&](std::size_t offset, std::size_t fine, double metres) {
    const double cm = std::trunc(metres * 100);
    relative.put_rounded<std::int32_t>(offset, cm);
    relative.put_rounded<std::int8_t>(fine, (metres * 100 - cm) * 100);  // 0.1 mm
  };
  for (std::size_t i = 0; i < 3; ++i) {
    put_length(8 + 4 * i, 32 + i, r_N[static_cast<Eigen::Index>(i)]);
  }
  put_length(20, 35, r_N.norm());
  const double heading = std::atan2(r_N.y(), r_N.x());
  relative.put_rounded<std::int32_t>(
      24, (heading < 0 ? heading + 2 * M_PI : heading) * base::kDegPerRad * 1e5);
  constexpr std::uint32_t kOneCentimetre = 100;  // 0.1 mm
  for (std::size_t offset = 36; offset < 52; offset += 4) relative.put(offset, kOneCentimetre);
  relative.put_rounded<std::uint32_t>(52, epoch.heading_accuracy_rad * base::kDegPerRad * 1e5);
  relative.put(60, has_fix(epoch) ? kFixedWithHeading : std::uint32_t{0});
  return relative.take();
}

UbxPayload mon_ver() {
  constexpr std::string_view kExtensions[]{"ROM BASE 0x118B2060", "FWVER=HPG 1.32", "PROTVER=27.31",
                                           "MOD=ZED-F9P", "GPS;GLO;GAL;BDS"};
  constexpr std::size_t kHead = 40;
  constexpr std::size_t kEach = 30;
  Fields version(kHead + kEach * std::size(kExtensions));
  version.put_text(0, "EXT CORE 1.00 (cas)");
  version.put_text(30, "00190000");
  for (std::size_t i = 0; i < std::size(kExtensions); ++i) {
    version.put_text(kHead + kEach * i, kExtensions[i]);
  }
  return version.take();
}

UbxPayload mon_rf(const UbxEpoch& epoch) {
  constexpr double kOpenSky_db_hz = 44;
  constexpr double kWarns_db = 5;
  constexpr double kCritical_db = 15;
  const double loss_db = std::max(0.0, kOpenSky_db_hz - epoch.fix.cn0_db_hz);
  Fields rf(28);
  rf.put(1, std::uint8_t{1});  // blocks
  rf.put(5, static_cast<std::uint8_t>(loss_db > kCritical_db ? 3 : loss_db > kWarns_db ? 2 : 1));
  rf.put(6, std::uint8_t{2});  // antenna: OK
  rf.put(7, std::uint8_t{1});  // and on
  rf.put_rounded<std::uint16_t>(16, 80 + loss_db);
  rf.put(18, std::uint16_t{4000});
  constexpr double kIndicatorPerDb = 8.5;
  rf.put_rounded<std::uint8_t>(20, loss_db * kIndicatorPerDb);
  return rf.take();
}

}  // namespace cas::sim
