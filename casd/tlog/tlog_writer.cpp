// SPDX-License-Identifier: BSD-3-Clause
#include "casd/tlog/tlog_writer.hpp"

#include <chrono>
#include <string>
#include <system_error>
#include <utility>

#include "base/error.hpp"

namespace cas::casd {
namespace {

// Written at the latest after this: a log survives a crash but for the last moments.
constexpr auto kFlushPeriod = std::chrono::milliseconds(200);
// Who is later than this has another clock: one that was set back, or a simulation begun anew.
constexpr std::uint64_t kClockStep_us = 1'000'000;

}  // namespace

TlogWriter::~TlogWriter() {
  stop();
  if (!thread_.joinable()) return;
  {
    const std::scoped_lock lock(mutex_);
    ending_ = true;
  }
  more_.notify_one();
  thread_.join();
}

void TlogWriter::start(TlogRecording::Options options) {
  stop();
  start_thread();
  {
    const base::RunTime now = base::steady_now();
    const std::scoped_lock files(files_mutex_);
    recording_.begin(std::move(options), now);
    recorded_ = 0;
    left_out_ = 0;
    {
      const std::scoped_lock lock(mutex_);
      set_zero(now);
      overflowed_ = 0;
      phase_.store(Phase::kRecording, std::memory_order_relaxed);
    }
    publish();
  }
  more_.notify_one();
}

// Nobody may find out only when a vehicle arms that the machine has no thread left.
void TlogWriter::start_thread() {
  if (thread_.joinable()) return;
  try {
    thread_ = std::thread([this] { run(); });
  } catch (const std::system_error& error) {
    throw base::ConfigError(std::string("cannot record: no thread for it: ") + error.what());
  }
}

void TlogWriter::stand_by() {
  start_thread();
  const std::scoped_lock lock(mutex_);
  stands_by_ = true;
  set_zero(base::steady_now());
  if (!active()) phase_.store(Phase::kStandby, std::memory_order_relaxed);
}

void TlogWriter::stop() {
  if (!active()) return;
  const std::scoped_lock files(files_mutex_);
  {
    const std::scoped_lock lock(mutex_);
    phase_.store(stands_by_ ? Phase::kStandby : Phase::kOff, std::memory_order_relaxed);
    take_waiting();
  }
  write_taken(base::steady_now());
  recording_.end();
  publish();
}

TlogStatus TlogWriter::status(base::RunTime now) const {
  const std::scoped_lock lock(status_mutex_);
  TlogStatus status = status_;
  if (!status.paused.empty()) status.paused_for = now - paused_since_;
  return status;
}

void TlogWriter::record(std::span<const std::uint8_t> packet, base::RunTime now) {
  if (!listens()) return;
  const std::scoped_lock lock(mutex_);
  const Phase phase = phase_.load(std::memory_order_relaxed);
  if (phase == Phase::kOff) return;
  const bool full = waiting_.size() + packet.size() > kMaxWaitingBytes;
  if (phase == Phase::kRecording && full) {
    ++overflowed_;
    return;
  }
  if (phase == Phase::kStandby && (full || now - stretch_began_ >= kKeptBefore)) {
    before_.swap(waiting_);
    waiting_.clear();
    stretch_began_ = now;
    set_zero(base::steady_now());
  }
  append_tlog_record(stamp_of(now), packet, waiting_);
}

/// With mutex_ held. Threads come a moment after they have read, so not in the order of their
/// times; readers of a log count on times that never go back.
std::uint64_t TlogWriter::stamp_of(base::RunTime now) {
  const auto us =
      static_cast<std::uint64_t>((now.time_since_epoch().count() + unix_minus_run_ns_) / 1000);
  const bool a_moment_late = us < newest_us_ && newest_us_ - us < kClockStep_us;
  if (!a_moment_late) newest_us_ = us;
  return newest_us_;
}

/// With mutex_ held: what the stamps are made from. When the wall clock was set back, what was kept
/// would lie behind what is to come.
void TlogWriter::set_zero(base::RunTime now) {
  const std::int64_t before = unix_minus_run_ns_;
  const auto unix_ns = std::chrono::duration_cast<std::chrono::nanoseconds>(
      std::chrono::system_clock::now().time_since_epoch());
  unix_minus_run_ns_ = epoch_ ? epoch_->count() : (unix_ns - now.time_since_epoch()).count();
  if (before - unix_minus_run_ns_ < static_cast<std::int64_t>(1000 * kClockStep_us)) return;
  before_.clear();
  waiting_.clear();
}

/// With both locks held.
void TlogWriter::take_waiting() {
  taken_before_.swap(before_);
  taken_.swap(waiting_);
  left_out_ += std::exchange(overflowed_, 0);
}

/// With files_mutex_ held.
void TlogWriter::write_taken(base::RunTime now) {
  for (std::vector<std::uint8_t>* taken : {&taken_before_, &taken_}) {
    if (taken->empty()) continue;
    const std::size_t written = recording_.write(*taken, now);
    recorded_ += written;
    left_out_ += count_tlog_records(*taken) - written;
    taken->clear();
  }
}

/// With files_mutex_ held.
void TlogWriter::publish() {
  const std::scoped_lock lock(status_mutex_);
  status_.active = active();
  status_.file = recording_.file();
  status_.paused = status_.active ? recording_.pause() : "";
  status_.recorded = recorded_;
  status_.left_out = left_out_;
  status_.bytes = recording_.bytes();
  paused_since_ = recording_.paused_since();
}

void TlogWriter::run() {
  for (;;) {
    {
      std::unique_lock lock(mutex_);
      more_.wait(lock, [this] { return ending_ || active(); });
      more_.wait_for(lock, kFlushPeriod, [this] { return ending_; });
      if (ending_) return;
    }
    flush(base::steady_now());
  }
}

void TlogWriter::flush(base::RunTime now) {
  const std::scoped_lock files(files_mutex_);
  {
    const std::scoped_lock lock(mutex_);
    if (!active()) return;  // stop() has written all
    take_waiting();
  }
  write_taken(now);
  publish();
}

}  // namespace cas::casd
