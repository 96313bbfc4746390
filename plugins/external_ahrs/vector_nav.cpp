// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/external_ahrs/vector_nav.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <utility>

namespace cas::sim {
namespace {

constexpr base::Duration kLate = std::chrono::milliseconds(1);

std::string name_of(UnitModel model) {
  constexpr std::array kNames{"VN-100", "VN-200", "VN-300"};
  return kNames[static_cast<std::size_t>(model)];
}

/// Rate of the inertial sensors, which the divisors in the registers divide.
double base_rate_hz(UnitModel model) { return model == UnitModel::kVn300 ? 400 : 800; }

}  // namespace

VectorNav::VectorNav(UnitModel model, unsigned baud)
    : base_hz_(base_rate_hz(model)), registers_(name_of(model)), line_(baud) {}

std::string VectorNav::take_answers(base::SimTime now) {
  line_.add(now, answers_.size());
  counts_.bytes += answers_.size();
  return std::exchange(answers_, {});
}

double VectorNav::rate_hz(std::size_t output) const {
  return registers_.running() ? registers_.outputs()[output].rate_hz(base_hz_) : 0;
}

/// The outputs that the registers ask for, counted from now on.
void VectorNav::rebuild(base::SimTime now) {
  revision_ = registers_.revision();
  streams_.clear();
  if (!registers_.running()) return;
  for (std::size_t i = 0; i < registers_.outputs().size(); ++i) {
    const BinaryOutput& output = registers_.outputs()[i];
    if (!output.on()) continue;
    Stream& stream = streams_.emplace_back();
    stream.output = i;
    stream.gate = base::RateGate(output.rate_hz(base_hz_));
    stream.gate.due(now);  // the next period counts
    stream.period = base::from_seconds(1 / output.rate_hz(base_hz_));
    stream.bytes = output.packet_bytes();
  }
  std::ranges::stable_sort(streams_, {}, &Stream::period);
}

void VectorNav::advance(base::SimTime now) {
  if (revision_ != registers_.revision()) rebuild(now);
  for (Stream& stream : streams_) {
    if (!stream.gate.due(now)) continue;
    if (stream.due) ++(stream.lacked_sample ? counts_.without_sample : counts_.dropped);
    stream.due = now;
    stream.lacked_sample = false;
  }
}

bool VectorNav::may_go(const Stream& stream, base::SimTime now) const {
  const base::Duration wait = line_.backlog(now);
  if (wait > kMostWait) return false;
  const Stream& fastest = streams_.front();
  if (stream.output == fastest.output) return true;
  const bool fits = wait + line_.time_of(stream.bytes) <= fastest.period;
  const bool waited_long = now - *stream.due >= stream.period / 2;
  const bool is_next = fastest.due && !fastest.lacked_sample;
  return !is_next && (fits || waited_long);
}

std::span<const std::uint8_t> VectorNav::next(base::SimTime now, const UnitReadings& readings,
                                              FreshSamples& fresh) {
  for (Stream& stream : streams_) {
    if (!stream.due) continue;
    const BinaryOutput& output = registers_.outputs()[stream.output];
    const bool of_fix = output.has_fix();
    const bool of_sample = !of_fix && output.has_inertial();
    stream.lacked_sample = (of_fix && !fresh.fix) || (of_sample && !fresh.inertial);
    if (stream.lacked_sample || !may_go(stream, now)) continue;
    const base::Duration wait = line_.backlog(now);
    output.build(readings, packet_);
    line_.add(now, packet_.size());
    stream.due.reset();
    if (of_fix) fresh.fix = false;
    if (of_sample) fresh.inertial = false;
    ++counts_.sent[stream.output];
    counts_.bytes += packet_.size();
    counts_.late += wait >= kLate ? 1 : 0;
    counts_.longest_wait = std::max(counts_.longest_wait, wait);
    return packet_;
  }
  return {};
}

void VectorNav::reset() {
  line_.reset();
  rebuild({});
}

}  // namespace cas::sim
