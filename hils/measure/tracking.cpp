// SPDX-License-Identifier: BSD-3-Clause
#include "hils/measure/tracking.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

#include "base/earth/frames.hpp"
#include "base/error.hpp"
#include "casd/tlog/tlog_packets.hpp"
#include "hils/measure/csv_file.hpp"
#include "hils/measure/truth_header.hpp"
#include "mavlink/common/attitude.hpp"
#include "mavlink/common/local_position_ned.hpp"
#include "mavlink/common/table.hpp"
#include "mavlink_gen/runtime/codec.hpp"

namespace cas::hils {

namespace {

/// Columns of truth.csv in the recorder's order, as far as they are read here.
enum Column : std::size_t {
  kTime = 0,
  kX,
  kY,
  kZ,
  kVx,
  kRoll = 7,
  kPitch,
  kYaw,
};

PoseSample to_sample(std::span<const double> row, const TruthHeader& header) {
  PoseSample sample{.time_us = std::llround(row[kTime] * 1e6),
                    .pose = {.x_m = row[kX],
                             .y_m = row[kY],
                             .z_m = row[kZ],
                             .roll_rad = row[kRoll],
                             .pitch_rad = row[kPitch],
                             .yaw_rad = row[kYaw]},
                    .v_m_s = {row[kVx], row[kVx + 1], row[kVx + 2]}};
  sample.rotors = static_cast<int>(header.rotors);
  std::copy_n(row.begin() + TruthHeader::kFirstRotor, header.rotors, sample.omega_rad_s.begin());
  if (header.airspeed) sample.airspeed_m_s = row[*header.airspeed];
  return sample;
}

}  // namespace

void ClockMap::add(std::int64_t log_us, std::int64_t sim_us) {
  if (!pairs_.empty() && log_us <= pairs_.back().first) return;  // the wall clock was set back
  pairs_.emplace_back(log_us, sim_us);
}

std::int64_t ClockMap::to_sim_us(std::int64_t log_us) const {
  if (pairs_.empty()) return log_us;
  const auto after =
      std::ranges::upper_bound(pairs_, log_us, {}, &std::pair<std::int64_t, std::int64_t>::first);
  if (after == pairs_.begin()) return after->second + (log_us - after->first);
  const auto before = after - 1;
  if (after == pairs_.end()) return before->second + (log_us - before->first);
  const double share = static_cast<double>(log_us - before->first) /
                       static_cast<double>(after->first - before->first);
  return before->second + std::llround(share * static_cast<double>(after->second - before->second));
}

std::vector<PoseSample> read_truth(const std::filesystem::path& file) {
  CsvFile csv(file);
  if (!csv.is_there()) throw base::ConfigError("cannot read " + file.string());
  const TruthHeader header = TruthHeader::parse(csv.header(), file);
  const std::size_t columns = header.columns();
  std::vector<PoseSample> samples;
  for (auto row = csv.next(columns); !row.empty(); row = csv.next(columns)) {
    samples.push_back(to_sample(row, header));
  }
  return samples;
}

std::vector<PoseSample> read_estimate(const std::filesystem::path& tlog, std::uint8_t system,
                                      const ClockMap& clock) {
  std::vector<PoseSample> samples;
  std::optional<mavlink::common::Attitude> attitude;
  const auto on_packet = [&](std::uint64_t stamp_us, const mav::PacketView& packet) {
    if (packet.source.system != system) return;
    if (const auto newer = mav::decode<mavlink::common::Attitude>(packet)) attitude = newer;
    const auto position = mav::decode<mavlink::common::LocalPositionNed>(packet);
    if (!position || !attitude) return;
    samples.push_back({.time_us = clock.to_sim_us(static_cast<std::int64_t>(stamp_us)),
                       .pose = {.x_m = position->x,
                                .y_m = position->y,
                                .z_m = -position->z,
                                .roll_rad = attitude->roll,
                                .pitch_rad = attitude->pitch,
                                .yaw_rad = attitude->yaw}});
  };
  if (!casd::for_each_tlog_packet(tlog, mavlink::common::table(), on_packet)) {
    throw base::ConfigError("cannot read " + tlog.string());
  }
  return samples;
}

std::span<const PoseSample> between(std::span<const PoseSample> samples, std::int64_t begin_us,
                                    std::int64_t end_us) {
  const auto first = std::ranges::lower_bound(samples, begin_us, {}, &PoseSample::time_us);
  const auto last = std::ranges::lower_bound(samples, end_us, {}, &PoseSample::time_us);
  if (last <= first) return {};
  return {first, last};
}

void RmsSums::add(const Pose& pose, const Pose& reference) {
  const double dyaw = base::wrap_angle(pose.yaw_rad - reference.yaw_rad);
  squares_.x_m += (pose.x_m - reference.x_m) * (pose.x_m - reference.x_m);
  squares_.y_m += (pose.y_m - reference.y_m) * (pose.y_m - reference.y_m);
  squares_.z_m += (pose.z_m - reference.z_m) * (pose.z_m - reference.z_m);
  squares_.yaw_rad += dyaw * dyaw;
  ++squares_.samples;
}

RmsFigures RmsSums::figures() const {
  const double n = static_cast<double>(std::max<std::uint64_t>(squares_.samples, 1));
  return {.x_m = std::sqrt(squares_.x_m / n),
          .y_m = std::sqrt(squares_.y_m / n),
          .z_m = std::sqrt(squares_.z_m / n),
          .yaw_rad = std::sqrt(squares_.yaw_rad / n),
          .samples = squares_.samples};
}

RmsFigures rms_about(std::span<const PoseSample> samples, const ReferenceAt& reference_at) {
  RmsSums sums;
  for (const PoseSample& sample : samples) sums.add(sample.pose, reference_at(sample.time_us));
  return sums.figures();
}

double peak_error_m(std::span<const PoseSample> samples, const ReferenceAt& reference_at) {
  double peak = 0;
  for (const PoseSample& sample : samples) {
    const Pose reference = reference_at(sample.time_us);
    peak =
        std::max(peak, std::hypot(sample.pose.x_m - reference.x_m, sample.pose.y_m - reference.y_m,
                                  sample.pose.z_m - reference.z_m));
  }
  return peak;
}

double height_error_m(std::span<const PoseSample> samples, const ReferenceAt& reference_at) {
  double sum_m = 0;
  for (const PoseSample& sample : samples) {
    sum_m += sample.pose.z_m - reference_at(sample.time_us).z_m;
  }
  return samples.empty() ? 0 : std::abs(sum_m / static_cast<double>(samples.size()));
}

double drift_m(std::span<const PoseSample> samples) {
  double farthest_m = 0;
  for (const PoseSample& sample : samples) {
    const Pose& begin = samples.front().pose;
    farthest_m =
        std::max(farthest_m, std::hypot(sample.pose.x_m - begin.x_m, sample.pose.y_m - begin.y_m));
  }
  return farthest_m;
}

double rotor_activity_rad_s2(std::span<const PoseSample> samples) {
  double squares = 0;
  double count = 0;
  for (std::size_t i = 1; i < samples.size(); ++i) {
    const double dt = 1e-6 * static_cast<double>(samples[i].time_us - samples[i - 1].time_us);
    if (!(dt > 0)) continue;
    for (std::size_t rotor = 0; rotor < static_cast<std::size_t>(samples[i].rotors); ++rotor) {
      squares +=
          std::pow((samples[i].omega_rad_s[rotor] - samples[i - 1].omega_rad_s[rotor]) / dt, 2);
      count += 1;
    }
  }
  return count > 0 ? std::sqrt(squares / count) : 0;
}

Pose reference_at(const Stage& stage, std::int64_t time_us) {
  Pose pose{.x_m = stage.reference_m.x(),
            .y_m = stage.reference_m.y(),
            .z_m = stage.reference_m.z(),
            .yaw_rad = stage.reference_yaw_rad};
  if (stage.step.kind != StepKind::kTrajectory) return pose;
  const auto accepted_us = static_cast<std::int64_t>(base::to_time_usec(stage.accepted));
  if (time_us < accepted_us) return pose;
  const Eigen::Vector3d offset =
      stage.step.trajectory.pattern()
          .at(1e-6 * static_cast<double>(time_us - accepted_us), Eigen::Vector3d::Zero(), 0)
          .p_N;
  pose.x_m += offset.x();
  pose.y_m += offset.y();
  pose.z_m -= offset.z();
  return pose;
}

Pose reference_in_estimate(const Stage& stage, std::int64_t time_us) {
  Pose pose = reference_at(stage, time_us);
  pose.x_m += stage.armed_at_N.x();
  pose.y_m += stage.armed_at_N.y();
  pose.z_m -= stage.armed_at_N.z();
  return pose;
}

ReferenceAt reference_in_truth(const Stage& stage, std::span<const PoseSample> truth) {
  const Pose start = truth.empty() ? Pose{} : truth.front().pose;
  return [&stage, start](std::int64_t time_us) {
    Pose pose = reference_at(stage, time_us);
    pose.x_m += start.x_m;
    pose.y_m += start.y_m;
    pose.z_m += start.z_m;
    return pose;
  };
}

}  // namespace cas::hils
