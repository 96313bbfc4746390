// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <chrono>
#include <functional>
#include <memory>
#include <string>

#include "base/time/clock.hpp"
#include "casd/link/ingress.hpp"
#include "casd/link/link.hpp"
#include "casd/link/tx_port.hpp"
#include "casd/topology/link_config.hpp"

namespace cas::casd {

/// How long a link waits before it tries again.
struct RetryTimes {
  base::Duration first = std::chrono::milliseconds(50);
  base::Duration longest = std::chrono::seconds(1);
};

/// When to try again: after RetryTimes::first, then twice as long each time, up to `longest`.
class Backoff {
 public:
  explicit Backoff(RetryTimes times) : times_(times) {}

  bool due(base::RunTime now) const { return now >= next_; }
  base::RunTime next() const { return next_; }
  /// An attempt failed.
  void failed(base::RunTime now) {
    next_ = now + delay_;
    delay_ = std::min(2 * delay_, times_.longest);
  }
  /// There is reason to look at this moment.
  void look_at(base::RunTime when) { next_ = when; }
  /// An attempt worked, or there is reason to believe that one will.
  void reset() {
    delay_ = times_.first;
    next_ = base::RunTime{};
  }

 private:
  RetryTimes times_;
  base::RunTime next_{};
  base::Duration delay_ = times_.first;
};

/// What writes to a link are held to while its line has this rate; 0: nothing.
double paced_bytes_s(const LinkConfig& config, unsigned baud);

/// What a link's sending side is held to; a line that may have several rates to the lowest.
/// @param signing  empty: none
TxPortOptions tx_port_options(const LinkConfig& config, std::shared_ptr<LinkSigning> signing = {});

/// What a link is made from.
struct LinkContext {
  LinkId id = kNoLink;
  LinkConfig config;
  Switchboard& switchboard;
  std::shared_ptr<LinkCounters> counters;
  std::shared_ptr<LinkSigning> signing;  ///< empty: none
  std::function<void()> wake;            ///< wakes the thread of the link's loop
  bool blocking = false;                 ///< threads: blocking
  LineDrain drain = LineDrain();         ///< the same: how it waits for the line
  RetryTimes retry = {};
};

/// What every kind of link does alike: state, back-off, the once-a-second chores.
class LinkCore {
 public:
  explicit LinkCore(LinkContext context);

  const LinkConfig& config() const { return context_.config; }
  LinkId id() const { return context_.id; }
  bool blocking() const { return context_.blocking; }
  LinkCounters& counters() { return *context_.counters; }
  std::uint64_t received() const { return context_.counters->rx.packets.get(); }
  std::shared_ptr<LinkCounters> shared_counters() const { return context_.counters; }
  Ingress& ingress() { return ingress_; }
  Backoff& backoff() { return backoff_; }

  /// @param endpoint  where it is now, for status and log
  void went_up(const std::string& endpoint);
  /// Arms the back-off; logs when the reason is new.
  void went_down(const std::string& reason, base::RunTime now);

  /// Has a second passed?
  bool second_due(base::RunTime now) const { return now >= next_second_; }
  base::RunTime next_second() const { return next_second_; }
  /// Routes that fell silent go.
  void on_second(base::RunTime now);

  /// Makes the sending side of the link, or of one peer of it: blocking or not as the topology
  /// says.
  std::shared_ptr<TxPort> make_port() const;

 private:
  LinkContext context_;
  Ingress ingress_;
  Backoff backoff_;
  bool was_up_ = false;
  std::string last_reason_;
  base::RunTime next_second_{};
};

}  // namespace cas::casd
