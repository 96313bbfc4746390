// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/line/line_model.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>

#include "base/random.hpp"
#include "base/suggestion.hpp"
#include "fcu/line/line_keys.hpp"

namespace cas::fcu {

using base::Duration;
using base::RunTime;
using namespace std::chrono_literals;

// Configuration.

namespace {

constexpr std::array<std::string_view, 5> kPresets{"ideal", "usb", "baud_921600", "baud_460800",
                                                   "baud_115200"};

/// A UART with the driver's send buffer and receive ring of a flight controller's.
LineConfig uart(const std::string& name, double baud) {
  LineConfig line;
  line.preset = name;
  line.baud = baud;
  line.send_buffer_bytes = 4096;
  line.receive_fifo_bytes = 4096;
  return line;
}

}  // namespace

LineConfig LineConfig::from_preset(const std::string& name) {
  if (name == "ideal") return {};
  if (name == "baud_921600") return uart(name, 921600);
  if (name == "baud_460800") return uart(name, 460800);
  if (name == "baud_115200") return uart(name, 115200);
  if (name == "usb") {
    LineConfig line;
    line.preset = name;
    line.baud = 12e6 / 8 * 10 * 0.8;  // full speed, protocol overhead taken off
    line.batch = 1ms;
    line.send_buffer_bytes = 16384;
    line.receive_fifo_bytes = 16384;
    return line;
  }
  throw base::ConfigError("line preset '" + name +
                          "' is unknown; there are ideal, usb, baud_921600, baud_460800, "
                          "baud_115200" +
                          base::did_you_mean(name, kPresets));
}

LineConfig LineConfig::parse(const base::ConfigNode& node) {
  LineConfig line;
  const auto preset = node.get<std::string>("preset", "ideal");
  try {
    line = from_preset(preset);
  } catch (const base::ConfigError& error) {
    node.at("preset").fail(error.what());
  }
  base::read_keys(node, kLineKeys, line);
  if (line.receiver_baud > 0 && line.receiver_baud < 1) {
    node.at("receiver_baud").fail("must be 0, the sender's, or at least 1");
  }
  if (line.receiver_baud > 0 && line.baud <= 0) {
    node.at("receiver_baud").fail("needs a line with a baud rate");
  }
  node.reject_unused();
  return line;
}

// One direction.

std::optional<std::uint8_t> read_at_other_rate(std::uint8_t sent, double ratio) {
  constexpr int kDataBits = 8;
  const auto level_at = [sent](double bit_times) {
    if (bit_times >= kDataBits + 1) return true;  // stop, idle
    const auto bit = static_cast<int>(bit_times);
    if (bit == 0) return false;              // start
    return ((sent >> (bit - 1)) & 1U) != 0;  // least significant first
  };
  if (level_at(0.5 * ratio)) return std::nullopt;  // no start bit
  unsigned read = 0;
  for (int bit = 0; bit < kDataBits; ++bit) {
    if (level_at((bit + 1.5) * ratio)) read |= 1U << bit;
  }
  if (!level_at((kDataBits + 1.5) * ratio)) return std::nullopt;
  return static_cast<std::uint8_t>(read);
}

LineModel::LineModel(const LineConfig& config, std::uint64_t seed)
    : config_(config), random_(seed) {}

Duration LineModel::byte_time() const {
  constexpr double kBitsPerByte = 10;  // start, eight data, stop
  if (config_.baud <= 0) return Duration{};
  return base::from_seconds(kBitsPerByte / config_.baud * (1 + 1e-6 * config_.clock_drift_ppm));
}

RunTime LineModel::EvenTimes::at(std::size_t i) const {
  RunTime t = first + static_cast<Duration::rep>(i) * step;
  if (batch > Duration{}) {
    const auto frames = (t.time_since_epoch().count() + batch.count() - 1) / batch.count();
    t = RunTime(frames * batch);
  }
  return std::max(t, earliest);
}

std::size_t LineModel::EvenTimes::count_by(RunTime t) const {
  if (t < earliest) return 0;
  // A moment rounded up is not later than t when it is not later than t rounded down.
  if (batch > Duration{}) t = RunTime(t.time_since_epoch() / batch * batch);
  if (t < first) return 0;
  if (step == Duration{}) return count;
  return std::min(count, static_cast<std::size_t>((t - first) / step) + 1);
}

bool LineModel::Stretch::wakes_at(std::size_t i) const {
  return (trigger != 0 && (i + 1) % trigger == 0) || (wakes && i + 1 == arrivals.count);
}

std::optional<RunTime> LineModel::Stretch::next_wake() const {
  const std::size_t last = arrivals.count - 1;
  const std::size_t next = trigger == 0 ? last : (read / trigger + 1) * trigger - 1;
  if (next < last) return arrivals.at(next);
  return wakes_at(last) ? std::optional(arrivals.at(last)) : std::nullopt;
}

std::size_t LineModel::unsent_at(RunTime now) const {
  std::size_t unsent = 0;
  for (auto bytes = sending_.rbegin(); bytes != sending_.rend(); ++bytes) {
    const std::size_t done = bytes->count_by(now);
    unsent += bytes->count - done;
    if (done > 0) break;
  }
  return unsent;
}

std::size_t LineModel::room(RunTime now) const {
  if (hung_up_) return 0;
  if (config_.send_buffer_bytes == 0) return SIZE_MAX;
  const std::size_t unsent = unsent_at(now);
  return unsent >= config_.send_buffer_bytes ? 0 : config_.send_buffer_bytes - unsent;
}

std::optional<RunTime> LineModel::room_at(RunTime now) const {
  if (hung_up_ || room(now) > 0) return std::nullopt;
  std::size_t newer = config_.send_buffer_bytes;  // the byte that many before the end leaves first
  auto bytes = sending_.rbegin();
  for (; bytes->count < newer; ++bytes) newer -= bytes->count;
  return bytes->at(bytes->count - newer);
}

RunTime LineModel::after_stalls(RunTime t) {
  const auto gap = [this] {
    const double u = 1 - random_.uniform();
    return base::from_seconds(-std::log(u) * base::to_seconds(config_.stall_every));
  };
  if (!stall_planned_) {
    next_stall_ = t + gap();
    stall_planned_ = true;
  }
  while (t >= next_stall_) {
    const RunTime end = next_stall_ + config_.stall_length;
    if (t < end) t = end;
    next_stall_ = end + gap();
  }
  return t;
}

RunTime LineModel::clock_byte(RunTime now, Duration byte_time) {
  done_ = std::max(now, done_) + byte_time;
  if (config_.stall_every > Duration{} && config_.stall_length > Duration{}) {
    done_ = after_stalls(done_);
  }
  return done_;
}

bool LineModel::byte_survives() {
  const double turn = in_burst_ ? config_.burst_end : config_.burst_begin;
  if (random_.uniform() < turn) in_burst_ = !in_burst_;
  return !in_burst_ || random_.uniform() >= config_.burst_loss;
}

std::uint8_t LineModel::with_bit_errors(std::uint8_t value) {
  constexpr std::uint64_t kBits = 8;
  if (!error_planned_) {
    const double u = 1 - random_.uniform();
    bits_to_next_error_ =
        static_cast<std::uint64_t>(std::log(u) / std::log1p(-config_.bit_error_rate));
    error_planned_ = true;
  }
  while (bits_to_next_error_ < kBits) {
    value = static_cast<std::uint8_t>(value ^ (1U << bits_to_next_error_));
    ++stats_.flipped;
    const double u = 1 - random_.uniform();
    bits_to_next_error_ +=
        1 + static_cast<std::uint64_t>(std::log(u) / std::log1p(-config_.bit_error_rate));
  }
  bits_to_next_error_ -= kBits;
  return value;
}

std::size_t LineModel::write(std::span<const std::uint8_t> bytes, RunTime now) {
  release_overdue(now);
  while (!sending_.empty() && sending_.front().count_by(now) == sending_.front().count) {
    sending_.pop_front();
  }
  const std::size_t taken = std::min(bytes.size(), room(now));
  stats_.written += taken;
  stats_.refused += bytes.size() - taken;
  if (taken == 0) return 0;

  const auto draw = [this](double probability) {
    return probability > 0 && random_.uniform() < probability;
  };
  const std::span<const std::uint8_t> one = bytes.first(taken);
  const bool twice = draw(config_.packet_duplicate);
  if (draw(config_.packet_reorder)) {
    if (held_.empty()) held_until_ = now + kLongestHold;
    held_.push_back({.bytes = {one.begin(), one.end()}, .twice = twice});
  } else {
    put(one, twice, now);
    release(now);
  }
  return taken;
}

void LineModel::put(std::span<const std::uint8_t> bytes, bool twice, RunTime now) {
  send(bytes, now);
  if (!twice) return;
  stats_.duplicated += bytes.size();
  send(bytes, now);
}

/// The newest goes first: it passes those before it.
void LineModel::release(RunTime now) {
  for (; !held_.empty(); held_.pop_back()) put(held_.back().bytes, held_.back().twice, now);
}

void LineModel::release_overdue(RunTime now) {
  if (!held_.empty() && held_until_ <= now) release(held_until_);
}

/// Whether all bytes of a write arrive, as they are and evenly.
bool LineModel::is_even() const {
  const bool stalls = config_.stall_every > Duration{} && config_.stall_length > Duration{};
  return !stalls && config_.burst_begin <= 0 && config_.bit_error_rate <= 0 &&
         config_.receiver_baud <= 0;
}

/// Puts bytes on the line. A second copy may take more room than the send buffer has.
void LineModel::send(std::span<const std::uint8_t> bytes, RunTime now) {
  const bool lost = config_.packet_loss > 0 && random_.uniform() < config_.packet_loss;
  Duration delay = config_.extra_delay;
  if (config_.jitter > Duration{}) {
    delay += base::from_seconds(random_.uniform() * base::to_seconds(config_.jitter));
  }
  is_even() && !lost ? send_evenly(bytes, delay, now) : send_singly(bytes, delay, lost, now);
  // A lost last byte must not leave the rest of the write waiting for the next one.
  if (!on_line_.empty()) on_line_.back().wakes = true;
}

/// Bytes that follow the last ones without a gap join their entry, so the cost of a walk over the
/// send buffer does not grow with the number of small writes.
void LineModel::note_sending(const EvenTimes& done) {
  if (config_.send_buffer_bytes == 0) return;
  if (!sending_.empty()) {
    EvenTimes& last = sending_.back();
    if (last.step == done.step && done.first == last.at(last.count)) {
      last.count += done.count;
      return;
    }
  }
  sending_.push_back(done);
}

void LineModel::send_evenly(std::span<const std::uint8_t> bytes, Duration delay, RunTime now) {
  const Duration byte_time = this->byte_time();
  const RunTime first = std::max(now, done_) + byte_time;
  const EvenTimes done{.first = first, .step = byte_time, .count = bytes.size()};
  done_ = done.at(done.count - 1);
  note_sending(done);
  EvenTimes arrivals = done;
  arrivals.first += delay;
  arrivals.batch = config_.batch;
  arrivals.earliest = last_arrival_;
  last_arrival_ = arrivals.at(arrivals.count - 1);
  on_line_.push_back({.arrivals = arrivals, .trigger = config_.receive_trigger_bytes});
  values_.insert(values_.end(), bytes.begin(), bytes.end());
}

/// Byte by byte, each with its own fate.
void LineModel::send_singly(std::span<const std::uint8_t> bytes, Duration delay, bool lost,
                            RunTime now) {
  const Duration byte_time = this->byte_time();
  const bool bursts = config_.burst_begin > 0;
  const bool bit_errors = config_.bit_error_rate > 0;
  const std::size_t trigger = config_.receive_trigger_bytes;
  const double ratio = config_.receiver_baud > 0 ? config_.baud / config_.receiver_baud : 1;
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    const RunTime sent = clock_byte(now, byte_time);
    note_sending({.first = sent, .step = byte_time});
    const bool survives = (!bursts || byte_survives()) && !lost;
    std::uint8_t value = bit_errors ? with_bit_errors(bytes[i]) : bytes[i];
    const std::optional<std::uint8_t> read =
        config_.receiver_baud > 0 ? read_at_other_rate(value, ratio) : value;
    if (!survives || !read) {
      ++stats_.lost;
      continue;
    }
    if (*read != value) ++stats_.misread;
    value = *read;
    const EvenTimes arrival{
        .first = sent + delay, .batch = config_.batch, .earliest = last_arrival_};
    last_arrival_ = arrival.at(0);
    const bool triggers = trigger != 0 && (i + 1) % trigger == 0;
    on_line_.push_back({.arrivals = arrival, .wakes = triggers || i + 1 == bytes.size()});
    values_.push_back(value);
  }
}

std::size_t LineModel::arrived_by(RunTime now) const {
  std::size_t arrived = 0;
  for (const Stretch& stretch : on_line_) {
    const std::size_t count = stretch.arrivals.count_by(now);
    arrived += count - std::min(count, stretch.read);
    if (count < stretch.arrivals.count) break;
  }
  return arrived;
}

/// Gives each byte on the line a stretch of its own.
void LineModel::part_stretches() {
  std::deque<Stretch> single;
  for (const Stretch& stretch : on_line_) {
    for (std::size_t i = stretch.read; i < stretch.arrivals.count; ++i) {
      single.push_back(
          {.arrivals = {.first = stretch.arrivals.at(i)}, .wakes = stretch.wakes_at(i)});
    }
  }
  on_line_ = std::move(single);
}

void LineModel::drop_overrun(RunTime now) {
  const std::size_t fifo = config_.receive_fifo_bytes;
  if (fifo == 0 || values_.size() <= fifo) return;
  const std::size_t arrived = arrived_by(now);
  if (arrived <= fifo) return;
  // The FIFO holds the oldest bytes; those that came when it was full are lost.
  part_stretches();
  const auto drop = [fifo, arrived](auto& bytes) {
    bytes.erase(bytes.begin() + static_cast<std::ptrdiff_t>(fifo),
                bytes.begin() + static_cast<std::ptrdiff_t>(arrived));
  };
  drop(on_line_);
  drop(values_);
  stats_.overrun += arrived - fifo;
}

std::size_t LineModel::read(std::span<std::uint8_t> out, RunTime now) {
  release_overdue(now);
  // Mostly nothing has arrived: bytes arrive in order, so the first decides.
  if (on_line_.empty() || on_line_.front().arrivals.at(on_line_.front().read) > now) return 0;
  drop_overrun(now);
  std::size_t count = 0;
  while (count < out.size() && !on_line_.empty()) {
    Stretch& front = on_line_.front();
    const std::size_t arrived = front.arrivals.count_by(now);
    if (arrived <= front.read) break;
    const std::size_t taken = std::min(arrived - front.read, out.size() - count);
    count += taken;
    front.read += taken;
    if (front.left() == 0) on_line_.pop_front();
  }
  const auto end = values_.begin() + static_cast<std::ptrdiff_t>(count);
  std::copy(values_.begin(), end, out.begin());
  values_.erase(values_.begin(), end);
  stats_.delivered += count;
  return count;
}

std::optional<RunTime> LineModel::next_arrival() const {
  std::optional<RunTime> next;
  if (!held_.empty()) next = held_until_;
  for (const Stretch& stretch : on_line_) {
    const std::optional<RunTime> wake = stretch.next_wake();
    if (!wake) continue;
    if (!next || *wake < *next) next = wake;
    break;
  }
  return next;
}

void LineModel::hang_up() {
  hung_up_ = true;
  stats_.lost += values_.size();
  for (const Held& held : held_) stats_.lost += held.bytes.size();
  on_line_.clear();
  values_.clear();
  held_.clear();
  sending_.clear();
}

EmulatorLine::EmulatorLine(const LineConfig& config, std::uint64_t seed)
    : up_(config, base::derive_seed(seed, "line_up")),
      down_(config, base::derive_seed(seed, "line_down")) {}

std::size_t EmulatorLine::up_room(base::RunTime now) const { return up_.room(now); }

void EmulatorLine::send(std::span<const std::uint8_t> packet, base::RunTime now) {
  if (held_ || down_.room(now) < packet.size()) {
    ++dropped_packets_;
    return;
  }
  down_.write(packet, now);
}

std::optional<base::RunTime> EmulatorLine::next_event(base::RunTime now) const {
  std::optional<base::RunTime> next;
  const auto earlier = [&next](std::optional<base::RunTime> t) {
    if (t && (!next || *t < *next)) next = t;
  };
  earlier(up_.next_arrival());
  earlier(down_.next_arrival());
  earlier(up_.room_at(now));
  return next;
}

void EmulatorLine::configure(const LineConfig& config) {
  up_.configure(config);
  down_.configure(config);
}

void EmulatorLine::hang_up() {
  up_.hang_up();
  down_.hang_up();
  held_ = false;
}

void EmulatorLine::restore() {
  up_.restore();
  down_.restore();
}

}  // namespace cas::fcu
