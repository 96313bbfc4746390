// SPDX-License-Identifier: BSD-3-Clause
#include "casd/station_scheduler.hpp"

#include <boost/asio/post.hpp>
#include <chrono>
#include <future>
#include <memory>

#include "base/time/unix_time.hpp"

namespace cas::casd {
namespace {

namespace asio = boost::asio;

constexpr auto kWallTick = std::chrono::milliseconds(500);
/// Longest hold of the stream. Bounded, because a reload waits for link threads, and no turn comes
/// at the end.
constexpr auto kTurnPatience = std::chrono::seconds(1);

}  // namespace

StationScheduler::StationScheduler(asio::io_context& io, LinkSet& links, OwnStation& station,
                                   Recorder& recorder)
    : io_(io), links_(links), station_(station), recorder_(recorder), timer_(io), packets_(io) {
  if (!lockstep()) return;
  links_.stream_time().enable([this](base::RunTime now) { hold_for_turn(now); });
  links_.tlog().set_epoch(TlogWriter::kStreamEpoch);
  links_.local().wake_for_all(false);
}

void StationScheduler::begin() {
  if (packets_.is_open()) {
    packets_.cancel();
  } else {
    packets_.assign(links_.local().descriptor());
  }
  do_wait();
  if (lockstep()) {
    do_wall_tick();
  } else {
    do_tick(base::steady_now() + kStationTick);
  }
}

void StationScheduler::end() {
  ending_.store(true);
  if (packets_.is_open()) packets_.release();
}

base::RunTime StationScheduler::now() const {
  return lockstep() ? links_.stream_time().now() : base::steady_now();
}

std::int64_t StationScheduler::log_clock_us() const {
  if (!lockstep()) return base::unix_us();
  return std::chrono::duration_cast<std::chrono::microseconds>(
             TlogWriter::kStreamEpoch + links_.stream_time().now().time_since_epoch())
      .count();
}

void StationScheduler::hear() { hear(now()); }

void StationScheduler::plan() {
  if (lockstep()) return;
  const base::RunTime due = station_.next_tick(base::steady_now());
  if (due < next_tick_) do_tick(due);
}

void StationScheduler::before_call() {
  if (!lockstep()) return asio::post(io_, [this] { plan(); });  // the call may be a request
  links_.local().wake_for_all(true);
  hear();
}

void StationScheduler::hear(base::RunTime now) {
  links_.local().dispatch(station_, now);
  recorder_.on_vehicles(station_.any_armed(now), now);
}

void StationScheduler::take_turn(base::RunTime now) {
  links_.local().wake_for_all(false);
  hear(now);
  station_.tick(now);
}

/// On a link's thread.
void StationScheduler::hold_for_turn(base::RunTime now) {
  if (ending_.load()) return;
  const auto over = std::make_shared<std::promise<void>>();
  asio::post(io_, [this, now, over] {
    take_turn(now);
    over->set_value();
  });
  over->get_future().wait_for(kTurnPatience);
}

void StationScheduler::do_wait() {
  packets_.async_wait(asio::posix::stream_descriptor::wait_read,
                      [this](boost::system::error_code error) {
                        if (error) return;
                        hear();
                        plan();
                        do_wait();
                      });
}

void StationScheduler::do_tick(base::RunTime due) {
  next_tick_ = due;
  timer_.expires_after(due - base::steady_now());
  timer_.async_wait([this](boost::system::error_code error) {
    if (error) return;
    const base::RunTime now = base::steady_now();
    station_.tick(now);
    station_.tick_failures(now);
    recorder_.on_vehicles(station_.any_armed(now), now);
    do_tick(station_.next_tick(now));
  });
}

/// Ends requests to a vehicle whose simulator is paused, and takes packets that arrived after the
/// last turn.
void StationScheduler::do_wall_tick() {
  timer_.expires_after(kWallTick);
  timer_.async_wait([this](boost::system::error_code error) {
    if (error) return;
    hear();
    station_.wall_tick(base::steady_now());
    do_wall_tick();
  });
}

}  // namespace cas::casd
