// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "base/os/mutex.hpp"
#include "casd/counters/echo_latency.hpp"
#include "casd/counters/message_taps.hpp"
#include "casd/link/stream_time.hpp"
#include "casd/packet/link_mask.hpp"
#include "casd/packet/packet_port.hpp"
#include "casd/routing/router.hpp"
#include "casd/tlog/tlog_writer.hpp"

namespace cas::casd {

/// The ports of all links, by slot: an immutable snapshot.
using PortTable = std::array<std::shared_ptr<PacketPort>, kLinkSlots>;

/// Packets that one read brought, sorted by destination, so that each destination gets them in one
/// call. Bytes lie end to end, so a run of packets to one link is one write.
class DeliveryBatch {
 public:
  DeliveryBatch();

  /// True when the next packet might not fit: deliver first.
  bool full() const { return infos_.size() == kMaxPackets; }
  bool empty() const { return infos_.empty(); }
  void add(const PacketInfo& info, std::span<const std::uint8_t> bytes, const LinkMask& to);
  /// Hands everything over and starts anew.
  /// @return how many packets a destination did not get for lack of memory
  std::size_t deliver(const PortTable& ports, base::RunTime now);

 private:
  static constexpr std::size_t kMaxPackets = 256;

  std::vector<PacketInfo> infos_;
  std::vector<std::uint8_t> bytes_;
  std::array<std::vector<PacketRef>, kLinkSlots> by_link_;
  LinkMask touched_;
};

/// What all links share: the router that decides, the ports that take packets, the log.
class Switchboard {
 public:
  explicit Switchboard(std::shared_ptr<const RoutingPlan> plan);

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
  base::Mutex mutex_;
  std::shared_ptr<const PortTable> ports_ CAS_GUARDED_BY(mutex_);
};

}  // namespace cas::casd
