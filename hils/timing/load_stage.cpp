// SPDX-License-Identifier: BSD-3-Clause
#include "hils/timing/load_stage.hpp"

#include <algorithm>
#include <cmath>

namespace cas::hils {

namespace {

/// Most questions without an answer, as a share; one is always allowed. A line that loses more
/// loses sensor samples in every flight.
constexpr double kMostLost = 0.001;
/// Default age limit of HIL packets in casd's queue.
constexpr double kMostQueue_ms = 25;
/// Bytes of a PING's answer; a TIMESYNC's are a few more.
constexpr double kAnswerBytes = 26;
constexpr double kLateShare = 0.75;

}  // namespace

bool LoadFigures::kept() const {
  const bool lossless = echoes.lost() <= 1 || echoes.lost_share() <= kMostLost;
  return !overloaded && echoes.answered > 0 && lossless &&
         late_median_ms - echoes.least_ms <= kMostQueue_ms;
}

LoadStage::LoadStage(ProbeLine& line, const LineDemand& demand, QuestionKind kind,
                     base::Duration length, base::RunTime begin)
    : line_(line),
      demand_(demand),
      kind_(kind),
      begin_(begin),
      end_(begin + length),
      gps_(demand.gps_hz),
      controls_(demand.controls_hz),
      stopped_at_(end_) {}

base::RunTime LoadStage::tick_time(std::int64_t tick) const {
  return begin_ + base::from_seconds(static_cast<double>(tick) / demand_.sensor_hz);
}

base::RunTime LoadStage::wake() const {
  const auto oldest = line_.oldest();
  const base::RunTime next = std::min(tick_time(tick_), end_);
  if (stopped_at_ != end_ || next >= end_) return oldest.value_or(end_) + kPatience;
  return next;
}

void LoadStage::turn(base::RunTime now) {
  if (done_) return;
  const auto oldest = line_.oldest();
  if (tick_time(tick_) <= end_ && oldest && now - *oldest > kHopeless && !overloaded_) {
    overloaded_ = true;
    stopped_at_ = std::min(now, end_);
  }
  for (int i = 0; !overloaded_ && i < kMostAtOnce && tick_time(tick_) <= std::min(now, end_); ++i) {
    lateness_.push_back(now - tick_time(tick_));
    send_sample(now, tick_time(tick_) - begin_);
    ++tick_;
  }
  look_for_end(now);
}

void LoadStage::send_sample(base::RunTime now, base::Duration since_begin) {
  const std::size_t before = line_.packets.bytes().size();
  std::size_t questions = 0;
  if (controls_.due(since_begin)) {
    questions = static_cast<std::size_t>(
        std::lround(static_cast<double>(controls_bytes(demand_)) / kAnswerBytes));
  }
  // The padding goes first, so that an answer comes when the whole sample is through.
  constexpr std::size_t kQuestionBytes = 28;
  const std::size_t most = (sensor_bytes() - ProbePackets::kLeastPadding) / kQuestionBytes;
  questions = std::min(questions, most);
  if (gps_.due(since_begin)) line_.packets.pad(gps_bytes());
  const std::size_t asking = questions * (kind_ == QuestionKind::kPing ? 24 : kQuestionBytes);
  line_.packets.pad(sensor_bytes() - asking);
  for (std::size_t i = 0; i < questions; ++i) line_.ask(kind_, now);
  asked_ += questions;
  sent_bytes_ += line_.packets.bytes().size() - before;
}

void LoadStage::look_for_end(base::RunTime now) {
  if (!overloaded_ && tick_time(tick_) <= end_) return;
  const auto oldest = line_.oldest();
  if (oldest && now - *oldest < kPatience) return;
  line_.forget_open();
  done_ = true;
}

void LoadStage::on_answer(std::uint32_t number, base::RunTime now) {
  const auto time = line_.answered(number, now);
  if (!time) return;
  round_trips_.push_back(*time);
  if (now >= begin_ + base::from_seconds(kLateShare * base::to_seconds(end_ - begin_))) {
    late_round_trips_.push_back(*time);
  }
}

void LoadStage::on_read(std::size_t bytes, base::RunTime now) {
  if (now >= stopped_at_) return;
  read_bytes_ += bytes;
  ++reads_;
  if (last_read_) longest_gap_ = std::max(longest_gap_, now - *last_read_);
  last_read_ = now;
}

LoadFigures LoadStage::figures() const {
  const double seconds = base::to_seconds(stopped_at_ - begin_);
  LoadFigures figures{.sensor_hz = demand_.sensor_hz,
                      .echoes = echo_figures(asked_, round_trips_),
                      .overloaded = overloaded_};
  if (seconds > 0) {
    figures.to_bytes_s = static_cast<double>(sent_bytes_) / seconds;
    figures.from_bytes_s = static_cast<double>(read_bytes_) / seconds;
  }
  figures.longest_gap_ms = 1e3 * base::to_seconds(longest_gap_);
  if (reads_ > 0) {
    figures.bytes_per_read = static_cast<double>(read_bytes_) / static_cast<double>(reads_);
  }
  figures.late_median_ms = echo_figures(late_round_trips_.size(), late_round_trips_).median_ms;
  figures.own_lateness_ms = echo_figures(lateness_.size(), lateness_).p99_ms;
  return figures;
}

}  // namespace cas::hils
