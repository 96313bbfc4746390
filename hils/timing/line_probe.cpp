// SPDX-License-Identifier: BSD-3-Clause
#include "hils/timing/line_probe.hpp"

#include <algorithm>
#include <array>

#include "mavlink/common/heartbeat.hpp"
#include "mavlink/common/hil_actuator_controls.hpp"
#include "mavlink/common/hil_controls.hpp"
#include "mavlink_gen/runtime/codec.hpp"
#include "mavlink_gen/runtime/public_table.hpp"

namespace cas::hils {

namespace {

using namespace mavlink::common;  // NOLINT: a dispatcher over its messages

/// As long as hils waits for one before a flight.
constexpr base::Duration kHeartbeatPatience = std::chrono::seconds(10);
constexpr base::Duration kBetweenHeartbeats = std::chrono::seconds(1);
/// Loads to try, as shares of the load that is wanted.
constexpr std::array kShares{0.25, 0.5, 0.75, 1.0, 1.25, 1.5};

bool is_hil_answer(const mav::PacketView& packet) {
  return packet.message_id == HilControls::kId || packet.message_id == HilActuatorControls::kId;
}

}  // namespace

LineProbe::LineProbe(const ProbePlan& plan, base::RunTime begin)
    : plan_(plan),
      parser_(mav::public_table(), mav::UnknownPolicy::kIgnore),
      phase_begin_(begin),
      next_heartbeat_(begin) {}

template <class Stage, class... Arguments>
void LineProbe::begin_stage(Phase phase, base::RunTime now, Arguments... arguments) {
  phase_ = phase;
  phase_begin_ = now;
  stage_ = std::make_unique<Stage>(line_, arguments..., now);
}

void LineProbe::end(ProbeEnd why) {
  figures_.end = why;
  figures_.crc_errors = parser_.stats().crc_errors;
  phase_ = Phase::kDone;
}

base::RunTime LineProbe::wake() const {
  base::RunTime next = next_heartbeat_;
  if (phase_ == Phase::kListen) next = std::min(next, phase_begin_ + kHeartbeatPatience);
  if (phase_ == Phase::kBackground) next = std::min(next, phase_begin_ + plan_.length);
  return stage_ ? std::min(next, stage_->wake()) : next;
}

void LineProbe::turn(base::RunTime now) {
  if (done()) return;
  if (now >= next_heartbeat_) {
    line_.packets.heartbeat();
    next_heartbeat_ = now + kBetweenHeartbeats;
  }
  if (!stage_) return listen(now);
  stage_->turn(now);
  // The next stage begins in the same turn: nothing else may wake this one.
  while (!done() && stage_->done()) {
    finish_stage(now);
    if (!done()) stage_->turn(now);
  }
}

void LineProbe::listen(base::RunTime now) {
  if (phase_ == Phase::kListen) {
    if (now - phase_begin_ >= kHeartbeatPatience) end(ProbeEnd::kSilent);
    return;
  }
  const base::Duration heard = now - phase_begin_;
  if (heard < plan_.length) return;
  figures_.background_bytes_s = static_cast<double>(background_bytes_) / base::to_seconds(heard);
  begin_stage<EchoStage>(Phase::kPing, now, QuestionKind::kPing, plan_.length, plan_.seed);
  stage_->turn(now);
}

void LineProbe::take(std::span<const std::uint8_t> bytes, base::RunTime now) {
  if (done()) return;
  if (phase_ == Phase::kBackground) background_bytes_ += bytes.size();
  if (stage_) stage_->on_read(bytes.size(), now);
  parser_.feed(bytes, [&](const mav::PacketView& packet) { on_packet(packet, now); });
}

void LineProbe::on_packet(const mav::PacketView& packet, base::RunTime now) {
  if (done()) return;
  if (packet.message_id == Heartbeat::kId) return on_heartbeat(packet, now);
  if (phase_ == Phase::kBackground && is_hil_answer(packet)) {
    background_bytes_ -= std::min(background_bytes_, packet.bytes.size());
  }
  if (!stage_ || packet.source != figures_.autopilot) return;
  if (const auto answer = read_answer(packet)) stage_->on_answer(answer->number, now);
}

void LineProbe::on_heartbeat(const mav::PacketView& packet, base::RunTime now) {
  const auto heartbeat = mav::decode<Heartbeat>(packet);
  const bool first = phase_ == Phase::kListen;
  if (!heartbeat || heartbeat->autopilot == MavAutopilot::kInvalid) return;
  if (first) {
    figures_.autopilot = packet.source;
    line_.packets.address(packet.source);
    phase_ = Phase::kBackground;
    phase_begin_ = now;
  }
  // Any armed vehicle on this line ends the probe: a line is not loaded in flight.
  if (has(heartbeat->base_mode, MavModeFlag::kSafetyArmed)) return end(ProbeEnd::kArmed);
  if (packet.source != figures_.autopilot) return;
  figures_.in_hil = has(heartbeat->base_mode, MavModeFlag::kHilEnabled);
}

void LineProbe::finish_stage(base::RunTime now) {
  using Way = FloodStage::Way;
  switch (phase_) {
    case Phase::kPing: {
      const auto& echo = static_cast<const EchoStage&>(*stage_);
      figures_.ping = echo.figures();
      arrivals_ = echo.arrivals();
      return begin_stage<EchoStage>(Phase::kTimesync, now, QuestionKind::kTimesync, plan_.length,
                                    plan_.seed + 1);
    }
    case Phase::kTimesync:
      finish_echoes();
      if (done()) return;
      return begin_stage<FloodStage>(Phase::kFloodTo, now, Way::kToBoard, figures_.asked,
                                     plan_.length);
    case Phase::kFloodTo:
      figures_.to_bytes_s = static_cast<const FloodStage&>(*stage_).bytes_s();
      return begin_stage<FloodStage>(Phase::kFloodFrom, now, Way::kFromBoard, figures_.asked,
                                     plan_.length);
    case Phase::kFloodFrom:
      figures_.from_bytes_s = static_cast<const FloodStage&>(*stage_).bytes_s();
      return begin_load(now);
    case Phase::kLoad:
      figures_.loads.push_back(static_cast<const LoadStage&>(*stage_).figures());
      return begin_load(now);
    case Phase::kSlower:
      figures_.slower.push_back(static_cast<const LoadStage&>(*stage_).figures());
      return begin_slower(now);
    case Phase::kListen:
    case Phase::kBackground:
    case Phase::kDone:
      return;
  }
}

void LineProbe::finish_echoes() {
  const auto& echo = static_cast<const EchoStage&>(*stage_);
  figures_.timesync = echo.figures();
  if (figures_.ping.answered == 0) {
    figures_.asked = QuestionKind::kTimesync;
    arrivals_ = echo.arrivals();
  }
  figures_.frame = arrival_frame(arrivals_);
  if (arrivals_.empty()) end(ProbeEnd::kNoAnswers);
}

void LineProbe::begin_load(base::RunTime now) {
  const std::size_t at = figures_.loads.size();
  if (at == kShares.size() || (at > 0 && !figures_.loads.back().kept())) return begin_slower(now);
  LineDemand demand = plan_.demand;
  demand.sensor_hz *= kShares[at];
  demand.gps_hz *= kShares[at];
  demand.controls_hz *= kShares[at];
  begin_stage<LoadStage>(Phase::kLoad, now, demand, figures_.asked, plan_.length);
}

bool LineProbe::slower_fits(double sensor_hz) const {
  const LineDemand demand = at_sensor_rate(plan_.demand, sensor_hz);
  return sensor_hz < plan_.demand.sensor_hz && budget_to(demand, figures_.to_bytes_s).fits() &&
         budget_from(demand, figures_.background_bytes_s, figures_.from_bytes_s).fits();
}

/// Where the wanted rate fits, nothing slower is looked for.
void LineProbe::begin_slower(base::RunTime now) {
  const bool wanted_fits =
      std::ranges::any_of(figures_.loads,
                          [this](const LoadFigures& load) {
                            return load.kept() && load.sensor_hz >= plan_.demand.sensor_hz;
                          }) &&
      budget_to(plan_.demand, figures_.to_bytes_s).fits() &&
      budget_from(plan_.demand, figures_.background_bytes_s, figures_.from_bytes_s).fits();
  const bool found = !figures_.slower.empty() && figures_.slower.back().kept();
  const auto rates = usual_sensor_rates();
  while (slower_at_ < rates.size() && !slower_fits(rates[slower_at_])) ++slower_at_;
  if (wanted_fits || found || slower_at_ == rates.size()) return end(ProbeEnd::kWhole);
  const LineDemand demand = at_sensor_rate(plan_.demand, rates[slower_at_++]);
  begin_stage<LoadStage>(Phase::kSlower, now, demand, figures_.asked, plan_.length);
}

}  // namespace cas::hils
