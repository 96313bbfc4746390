// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <boost/asio/io_context.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <boost/asio/steady_timer.hpp>
#include <cstdint>

#include "base/time/clock.hpp"
#include "casd/link_set.hpp"
#include "casd/own_station.hpp"
#include "casd/tlog/recorder.hpp"

namespace cas::casd {

/// Decides when casd's own station gets its packets and does its work: on the thread of `io`, as
/// soon as a packet has come or something is due.
///
/// In lockstep the stream of HIL_SENSOR gives the turns, by its own clock: it is held on its link's
/// thread while the station has its turn on the main thread.
class StationScheduler {
 public:
  /// In lockstep takes over the stream's turns: to be made before the links start. All outlive it.
  StationScheduler(boost::asio::io_context& io, LinkSet& links, OwnStation& station,
                   Recorder& recorder);
  ~StationScheduler() { end(); }

  /// Starts the timers and the wait for packets. To be called after the links have started.
  void begin();
  /// Gives no more turns. To be called before the links stop.
  void end();

  /// The station's clock.
  base::RunTime now() const;
  /// The clock of a recording's stamps, as TlogWriter makes them: us since 1970.
  std::int64_t log_clock_us() const;
  /// Gives the station its packets.
  void hear();
  /// Something may have become due sooner.
  void plan();
  /// A client calls. In lockstep telemetry wakes the main thread, which would share a processor
  /// with the stream, only from here to the next turn: the client gets new values, and immediate
  /// answers even while the simulation is paused.
  void before_call();

 private:
  bool lockstep() const { return links_.topology().pace == Pace::kLockstep; }
  void hear(base::RunTime now);
  void take_turn(base::RunTime now);
  void hold_for_turn(base::RunTime now);
  void do_wait();
  void do_tick(base::RunTime due);
  void do_wall_tick();

  boost::asio::io_context& io_;
  LinkSet& links_;
  OwnStation& station_;
  Recorder& recorder_;
  boost::asio::steady_timer timer_;
  boost::asio::posix::stream_descriptor packets_;
  base::RunTime next_tick_ = base::RunTime::max();  ///< max: none is awaited
  std::atomic<bool> ending_{false};
};

}  // namespace cas::casd
