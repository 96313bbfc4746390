// SPDX-License-Identifier: BSD-3-Clause
#include "hils/ulog/run_ulog.hpp"

#include <fmt/format.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/config/vehicle.hpp"
#include "base/earth/atmosphere.hpp"
#include "base/earth/frames.hpp"
#include "base/earth/geodesy.hpp"
#include "fcu/flight_controller.hpp"
#include "fcu/params/params.hpp"
#include "hils/measure/csv_file.hpp"
#include "hils/measure/record_tracks.hpp"
#include "hils/measure/truth_header.hpp"
#include "hils/ulog/telemetry_ulog.hpp"
#include "hils/ulog/ulog_topics.hpp"

namespace cas::hils {

namespace {

using base::SimTime;
using sim::UlogRecord;
using Topic = UlogTopicId;
using TopicRow = std::span<const double>;

UlogRecord& put_three(UlogRecord& record, const TopicRow& row, std::size_t first) {
  return record.put_float(row[first]).put_float(row[first + 1]).put_float(row[first + 2]);
}

/// A row of truth.csv: z up there, down here.
///
/// @param home  the origin's place on earth; nullopt: the run has none
void write_truth(sim::UlogFile& file, const std::optional<base::Geodetic>& home,
                 const TruthHeader& header, SimTime time, const TopicRow& row) {
  const Eigen::Vector3d p_N(row[1], row[2], -row[3]);
  const Eigen::Vector3d v_N(row[4], row[5], -row[6]);
  const Eigen::Quaterniond q = base::quaternion_rpy(row[7], row[8], row[9]);
  write(file, Topic::kAttitudeTruth,
        UlogRecord(time).put_float(q.w()).put_float(q.x()).put_float(q.y()).put_float(q.z()));
  UlogRecord rates(time);
  write(file, Topic::kAngularVelocityTruth, put_three(rates, row, 10));
  write(file, Topic::kLocalPositionTruth, UlogRecord(time).put_floats(p_N).put_floats(v_N));
  UlogRecord speeds(time);
  for (std::size_t i = 0; i < header.rotors; ++i) {
    speeds.put_float(row[TruthHeader::kFirstRotor + i]);
  }
  write(file, Topic::kRotorSpeeds, speeds);
  if (header.airspeed) {
    write(file, Topic::kAirspeedTruth, UlogRecord(time).put_float(row[*header.airspeed]));
  }
  if (header.wing) {
    UlogRecord wing(time);
    const std::size_t columns = TruthHeader::kWingColumns + header.surfaces;
    for (const double value : row.subspan(*header.wing, columns)) wing.put_float(value);
    write(file, Topic::kWingTruth, wing);
  }
  if (!home) return;
  const base::Geodetic place = base::LocalProjection(*home).to_geodetic(p_N);
  write(file, Topic::kGlobalPositionTruth,
        UlogRecord(time).put(place.lat_deg).put(place.lon_deg).put_float(place.alt_m));
}

void write_imu(sim::UlogFile& file, SimTime time, const TopicRow& row) {
  UlogRecord record(time);
  write(file, Topic::kSensorCombined, put_three(put_three(record, row, 1), row, 4));
}

void write_gps(sim::UlogFile& file, SimTime time, const TopicRow& row) {
  const double north = row[6];
  const double east = row[7];
  write(file, Topic::kGpsPosition,
        UlogRecord(time)
            .put(row[3])
            .put(row[4])
            .put(row[5])
            .put_float(row[9])
            .put_float(row[10])
            .put_float(std::hypot(north, east))
            .put_float(north)
            .put_float(east)
            .put_float(row[8])
            .put_float(std::atan2(east, north))
            .put(static_cast<std::uint8_t>(row[1]))
            .put(static_cast<std::uint8_t>(row[2])));
}

void write_magnetometer(sim::UlogFile& file, SimTime time, const TopicRow& row) {
  UlogRecord record(time);
  write(file, Topic::kMagnetometer, put_three(record, row, 1));
}

void write_barometer(sim::UlogFile& file, SimTime time, const TopicRow& row) {
  write(file, Topic::kAirData,
        UlogRecord(time)
            .put_float(base::isa::altitude_m(row[1]))
            .put_float(row[1])
            .put_float(row[2]));
}

void write_rangefinder(sim::UlogFile& file, SimTime time, const TopicRow& row) {
  constexpr std::int8_t kUnknown = -1;  // of distance_sensor.msg; 0: no signal
  write(file, Topic::kDistance,
        UlogRecord(time).put_float(row[1]).put(row[2] > 0 ? kUnknown : std::int8_t{0}));
}

void write_pressure_difference(sim::UlogFile& file, SimTime time, const TopicRow& row) {
  write(file, Topic::kDifferentialPressure, UlogRecord(time).put_float(row[1]));
}

/// The emulated controller's initial parameters; empty for a real one, whose file is not available.
std::vector<sim::UlogParam> initial_params(const RunRequest& request, std::size_t vehicle,
                                           const VehiclePaths& paths) {
  std::vector<sim::UlogParam> params;
  if (request.scenario.firmware || request.fcu_device(vehicle) != nullptr) return params;
  const fcu::FlightController controller(fcu::FcuConfig::load(paths.fcu_config()), [](auto) {});
  const fcu::ParamStore& store = controller.params();
  for (std::size_t i = 0; i < store.size(); ++i) {
    const fcu::Param& param = store.at(i);
    params.push_back({.name = param.name,
                      .is_integer = param.type == fcu::ParamType::kInt32,
                      .value = param.value});
  }
  return params;
}

/// "1.2.3" as ULog has versions: a byte each, and 255 for a release.
std::uint32_t version_number(const char* version) {
  unsigned major = 0;
  unsigned minor = 0;
  unsigned patch = 0;
  std::sscanf(version, "%u.%u.%u", &major, &minor, &patch);
  return major << 24U | minor << 16U | patch << 8U | 255U;
}

std::vector<sim::UlogInfo> infos(const RunRequest& request, const RunRecord& record) {
  constexpr std::uint32_t kDataFormat = 2;  // vehicle_gps_position in degrees and metres
  using sim::UlogInfo;
  std::vector<UlogInfo> infos{
      UlogInfo::uint32("ver_data_format", kDataFormat),
      UlogInfo::int32("time_ref_utc", 0),  // simulated time knows no time zone
      UlogInfo::text("cas_version", CAS_VERSION),
      UlogInfo::text("cas_scenario", request.scenario.name),
      UlogInfo::text("cas_vehicle", record.vehicle),
      UlogInfo::text("cas_architecture", to_string(request.architecture)),
      UlogInfo::text("cas_seed", std::to_string(request.seed))};
  if (record.firmware) {
    infos.push_back(UlogInfo::text("ver_sw", record.firmware->version));
  } else if (!record.from_device) {
    infos.push_back(UlogInfo::text("ver_hw", "fcu_emulator"));
    infos.push_back(UlogInfo::text("ver_sw", CAS_VERSION));
    infos.push_back(UlogInfo::uint32("ver_sw_release", version_number(CAS_VERSION)));
  }
  return infos;
}

}  // namespace

void write_ulog(const RunRequest& request, const RunRecord& record, std::size_t vehicle) {
  const RunPaths paths = RunPaths::of(request.scenario, request.out, request.out / "run");
  const VehiclePaths& own = paths.vehicles.at(vehicle);
  const std::vector<sim::UlogParam> params = initial_params(request, vehicle, own);
  const TruthHeader header =
      TruthHeader::parse(CsvFile(record.truth_csv).header(), record.truth_csv);
  const std::string wing =
      header.wing ? sim::wing_fields(static_cast<int>(header.surfaces)) : std::string();
  sim::UlogFile file(
      {own.out, own.flight_ulog()},
      ulog_topics(static_cast<int>(header.rotors), header.airspeed.has_value(), wing),
      infos(request, record), params);
  const std::optional<base::Geodetic> home = request.scenario.home;

  TelemetryUlog telemetry(file, record.system, params);
  RecordTracks tracks;
  const auto add_csv = [&](const std::filesystem::path& path, std::size_t columns, auto write) {
    tracks.add_csv(path, columns,
                   [&file, write](SimTime time, const TopicRow& row) { write(file, time, row); });
  };
  add_csv(record.truth_csv, header.columns(),
          [&](sim::UlogFile& to, SimTime time, const TopicRow& row) {
            write_truth(to, home, header, time, row);
          });
  add_csv(record.sensors / "imu.csv", 7, write_imu);
  add_csv(record.sensors / "gps.csv", 11, write_gps);
  add_csv(record.sensors / "magnetometer.csv", 4, write_magnetometer);
  add_csv(record.sensors / "barometer.csv", 3, write_barometer);
  add_csv(record.sensors / "rangefinder.csv", 3, write_rangefinder);
  if (header.airspeed) add_csv(record.sensors / "airspeed.csv", 2, write_pressure_difference);
  tracks.add_tlog(record, [&telemetry](SimTime time, const mav::PacketView& packet) {
    telemetry.on_packet(time, packet);
  });
  tracks.run();
  file.close();
}

}  // namespace cas::hils
