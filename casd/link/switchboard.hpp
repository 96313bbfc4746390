// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <memory>
#include <mutex>

#include "casd/counters/echo_latency.hpp"
#include "casd/counters/message_taps.hpp"
#include "casd/link/delivery_batch.hpp"
#include "casd/link/stream_time.hpp"
#include "casd/routing/router.hpp"
#include "casd/tlog/tlog_writer.hpp"

namespace cas::casd {

/// What all links share: the router that decides, the ports that take packets, the log.
class Switchboard {
 public:
  explicit Switchboard(std::shared_ptr<const RoutingPlan> plan, base::Duration route_lifetime);

  Router& router() { return router_; }
  TlogWriter& tlog() { return tlog_; }
  MessageTaps& taps() { return taps_; }
  EchoLatency& echo() { return echo_; }
  StreamTime& stream_time() { return stream_time_; }

  /// Puts other ports in force; links take them over at their next packet.
  void set_ports(std::shared_ptr<const PortTable> ports);
  /// The ports in force, when they are others than those of `generation`.
  std::shared_ptr<const PortTable> ports_after(std::uint64_t& generation);

 private:
  Router router_;
  TlogWriter tlog_;
  MessageTaps taps_;
  EchoLatency echo_;
  StreamTime stream_time_;
  std::atomic<std::uint64_t> generation_{1};
  std::mutex mutex_;
  std::shared_ptr<const PortTable> ports_;
};

}  // namespace cas::casd
