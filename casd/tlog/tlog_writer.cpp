// SPDX-License-Identifier: BSD-3-Clause
#include "casd/tlog/tlog_writer.hpp"

#include <chrono>
#include <future>
#include <new>
#include <string>
#include <system_error>
#include <utility>

#include "base/error.hpp"
#include "base/os/lack_of_memory.hpp"
#include "base/os/log.hpp"

namespace cas::casd {
namespace {

// A crash costs a log this much at most.
constexpr auto kFlushPeriod = std::chrono::milliseconds(200);
// Between recordings, time between two looks whether the folder takes one.
constexpr base::Duration kLookPeriod = std::chrono::seconds(10);
// A larger step back is another clock: it was set back, or a simulation has restarted.
constexpr std::uint64_t kClockStep_us = 1'000'000;

constexpr const char* kWho = "recording";

void ignore(const std::optional<std::string>& /*fault*/, const TlogStatus& /*status*/) {}

}  // namespace

TlogWriter::~TlogWriter() { stop(ignore); }

void TlogWriter::start(TlogRecording::Options options, Done done) {
  start_thread();
  {
    const base::MutexLock lock(status_mutex_);
    ++beginning_;
  }
  {
    const base::MutexLock lock(mutex_);
    if (active()) order_end(ignore);
    orders_.push_back({.begin = std::move(options), .rest = {}, .done = std::move(done)});
    set_zero(base::steady_now());
    overflowed_ = 0;
    phase_.store(Phase::kRecording, std::memory_order_relaxed);
  }
  more_.notify_one();
}

void TlogWriter::start(TlogRecording::Options options) {
  std::promise<std::optional<std::string>> answer;
  start(std::move(options),
        [&answer](const auto& fault, const TlogStatus&) { answer.set_value(fault); });
  if (const auto fault = answer.get_future().get()) throw base::ConfigError(*fault);
}

/// @param first  done on the thread before anything else
void TlogWriter::start_thread(std::function<void()> first) {
  if (thread_.joinable()) return;
  try {
    thread_ = std::jthread([this, first = std::move(first)](const std::stop_token& stop) {
      if (first) base::outlive_lack_of_memory(kWho, first);
      for (bool goes_on = true; goes_on;) {
        base::outlive_lack_of_memory(kWho, [&] { goes_on = work(stop); });
      }
    });
  } catch (const std::system_error& error) {
    throw base::ConfigError(std::string("cannot record: no thread for it: ") + error.what());
  }
}

// A machine without a free thread or with a bad folder shows it now, not at the first flight.
void TlogWriter::stand_by(LogFolder folder, LogLimits limits) {
  start_thread([this, folder = std::move(folder), limits] {
    folder_ = folder;
    limits_ = limits;
    look_at_folder(base::steady_now());
    publish();
  });
  const base::MutexLock lock(mutex_);
  stands_by_ = true;
  set_zero(base::steady_now());
  if (!active()) phase_.store(Phase::kStandby, std::memory_order_relaxed);
}

void TlogWriter::stop(Done done) {
  {
    const base::MutexLock lock(mutex_);
    if (active()) {
      order_end(std::move(done));
      phase_.store(stands_by_ ? Phase::kStandby : Phase::kOff, std::memory_order_relaxed);
      done = nullptr;
    }
  }
  if (done) return done(std::nullopt, status(base::steady_now()));
  more_.notify_one();
}

void TlogWriter::stop() {
  std::promise<void> answer;
  stop([&answer](const auto&, const TlogStatus&) { answer.set_value(); });
  answer.get_future().wait();
}

void TlogWriter::order_end(Done done) {
  Order end{.begin = std::nullopt, .rest = take_waiting(), .done = std::move(done)};
  const std::size_t bytes = end.rest.before.size() + end.rest.records.size();
  if (ordered_bytes_ + bytes > 2 * kMaxWaitingBytes) {  // flight after flight, and the disk hangs
    end.rest = {.before = {},
                .records = {},
                .overflowed = end.rest.overflowed + count_tlog_records(end.rest.before) +
                              count_tlog_records(end.rest.records)};
  } else {
    ordered_bytes_ += bytes;
  }
  orders_.push_back(std::move(end));
}

TlogStatus TlogWriter::status(base::RunTime now) const {
  constexpr base::Duration kPatience = std::chrono::seconds(1);
  const base::MutexLock lock(status_mutex_);
  TlogStatus status;
  status.active = true;
  if (beginning_ == 0) status = status_;
  if (status.paused) status.paused_for = now - paused_since_;
  const base::Duration hangs =
      asked_disk_ ? base::steady_now() - *asked_disk_ : base::Duration::zero();
  if (status.active && hangs > kPatience) {
    status.paused = "the disk does not answer";
    status.paused_for = hangs;
  }
  return status;
}

void TlogWriter::record(std::span<const std::uint8_t> packet, base::RunTime now) {
  if (!listens()) return;
  const base::MutexLock lock(mutex_);
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
  const std::uint64_t stamp = stamp_of(now);
  std::vector<std::uint8_t>* const waiting = &waiting_;  // a lambda does not know of the lock
  const bool kept =
      base::outlive_lack_of_memory(kWho, [&] { append_tlog_record(stamp, packet, *waiting); });
  if (!kept) ++overflowed_;
}

/// A thread brings its packet a moment after it was read, so packets come out of order; readers of
/// a log expect times that never go back.
std::uint64_t TlogWriter::stamp_of(base::RunTime now) {
  const auto us =
      static_cast<std::uint64_t>((now.time_since_epoch().count() + unix_minus_run_ns_) / 1000);
  const bool a_moment_late = us < newest_us_ && newest_us_ - us < kClockStep_us;
  if (!a_moment_late) newest_us_ = us;
  return newest_us_;
}

/// Sets the wall clock at run time zero, from which the stamps are made. If the wall clock was set
/// back, kept packets would have later stamps than those to come: they are dropped.
void TlogWriter::set_zero(base::RunTime now) {
  const std::int64_t before = unix_minus_run_ns_;
  const auto unix_ns = std::chrono::duration_cast<std::chrono::nanoseconds>(
      std::chrono::system_clock::now().time_since_epoch());
  unix_minus_run_ns_ = epoch_ ? epoch_->count() : (unix_ns - now.time_since_epoch()).count();
  if (before - unix_minus_run_ns_ < static_cast<std::int64_t>(1000 * kClockStep_us)) return;
  before_.clear();
  waiting_.clear();
}

TlogWriter::Load TlogWriter::take_waiting() {
  return {.before = std::exchange(before_, {}),
          .records = std::exchange(waiting_, {}),
          .overflowed = std::exchange(overflowed_, 0)};
}

void TlogWriter::write(const Load& load, base::RunTime now) {
  const auto take_out_deleted = [this] {
    const std::uint64_t deleted = recording_.leave_deleted();
    recorded_ -= deleted;
    left_out_ += deleted;
  };
  take_out_deleted();  // before the next file takes its place
  left_out_ += load.overflowed;
  for (const std::vector<std::uint8_t>* taken : {&load.before, &load.records}) {
    if (taken->empty()) continue;
    std::size_t written = 0;
    base::outlive_lack_of_memory(kWho, [&] { written = recording_.write(*taken, now); });
    recorded_ += written;
    left_out_ += count_tlog_records(*taken) - written;
  }
  take_out_deleted();
}

TlogStatus TlogWriter::publish() {
  const base::MutexLock lock(status_mutex_);
  status_.active = open_;
  status_.file = recording_.file();
  status_.paused = open_ ? recording_.pause() : fault_between_;
  status_.recorded = recorded_;
  status_.left_out = left_out_;
  status_.bytes = recording_.bytes();
  paused_since_ = open_ ? recording_.paused_since() : fault_since_;
  return status_;
}

/// Between recordings: could one begin?
void TlogWriter::look_at_folder(base::RunTime now) {
  const auto why = folder_->hindrance(limits_, TlogRecording::kRoomToGoOn);
  const std::string folder = folder_->path().string();
  if (why && !fault_between_) {
    fault_since_ = now;
    base::log::error("cannot record in " + folder + " now: " + *why + "; casd goes on trying");
  } else if (!why && fault_between_) {
    base::log::info("can record in " + folder + " again");
  }
  fault_between_ = why;
}

/// Orders first: packets that wait belong to the recording that was begun last.
bool TlogWriter::work(const std::stop_token& stop) {
  std::deque<Order> orders;
  Load load;
  bool looks = false;
  {
    base::MutexLock lock(mutex_);
    const auto has_orders = [this]() CAS_REQUIRES(mutex_) { return !orders_.empty(); };
    const auto works = [&]() CAS_REQUIRES(mutex_) { return has_orders() || active(); };
    if (folder_) {
      more_.wait_for(lock, stop, fault_between_ ? TlogRecording::kRetryPeriod : kLookPeriod, works);
    } else {
      more_.wait(lock, stop, works);
    }
    if (works()) more_.wait_for(lock, stop, kFlushPeriod, has_orders);
    if (stop.stop_requested() && orders_.empty()) return false;
    looks = folder_ && !works();
    orders.swap(orders_);
    ordered_bytes_ = 0;
    if (active()) load = take_waiting();
  }
  const base::RunTime now = base::steady_now();
  {
    const base::MutexLock lock(status_mutex_);
    asked_disk_ = now;
  }
  for (; !orders.empty(); orders.pop_front()) {
    Order& order = orders.front();
    const auto carry = [&] { carry_out(order, orders.size() == 1, now); };
    if (!base::outlive_lack_of_memory(kWho, carry)) order.done("no memory", {});
  }
  if (open_) write(load, now);
  if (looks && !open_) look_at_folder(now);
  publish();
  const base::MutexLock lock(status_mutex_);
  asked_disk_.reset();
  return true;
}

/// @param newest  whether it is the last that was taken
void TlogWriter::carry_out(Order& order, bool newest, base::RunTime now) {
  if (order.begin) return begin_recording(order, newest, now);
  if (open_) {
    write(order.rest, now);
    fault_between_ = recording_.pause();
    fault_since_ = recording_.paused_since();
    recording_.end();
  }
  open_ = false;
  order.done(std::nullopt, publish());
}

void TlogWriter::begin_recording(Order& order, bool newest, base::RunTime now) {
  std::optional<std::string> fault;
  try {
    recording_.begin(std::move(*order.begin), now);
    recorded_ = 0;
    left_out_ = 0;
    open_ = true;
  } catch (const base::ConfigError& error) {
    fault = error.what();
  } catch (const std::bad_alloc&) {
    fault = "no memory";
  }
  if (fault && newest) begin_failed();
  TlogStatus status;
  base::outlive_lack_of_memory(kWho, [&] { status = publish(); });
  {
    const base::MutexLock lock(status_mutex_);
    --beginning_;
  }
  order.done(fault, status);
}

/// Stops recording, unless main has ordered another recording or an end meanwhile.
void TlogWriter::begin_failed() {
  const base::MutexLock lock(mutex_);
  if (!orders_.empty() || !active()) return;
  phase_.store(stands_by_ ? Phase::kStandby : Phase::kOff, std::memory_order_relaxed);
  if (!stands_by_) take_waiting();
}

}  // namespace cas::casd
