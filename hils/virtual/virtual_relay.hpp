// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/time/clock.hpp"
#include "casd/counters/link_ledger.hpp"
#include "casd/queue/line_timing.hpp"
#include "casd/queue/tx_queue.hpp"
#include "casd/routing/router.hpp"
#include "casd/station/vehicle_commander.hpp"
#include "casd/topology/topology.hpp"
#include "hils/scenario/wake_up.hpp"
#include "mavlink_gen/runtime/packet_parser.hpp"

namespace cas::hils {

/// casd without sockets and threads: its own router, queues, pacers and ground station, moved by
/// the virtual clock. Computing takes no time; lines do.
///
///   receive() --> parser --> Router --> queue of each destination --> pacer --> write
///                              +--> own station (VehicleCommander)
///
/// threads: per_link and single are the same here: neither waits for a line. With threads: blocking
/// the one thread is modelled: in each turn it takes all waiting datagrams, reads what has come on
/// each line (waiting for the rest of a packet that has begun) and writes one packet to each paced
/// line (waiting until the line is through with it); what comes meanwhile stays in the kernel's
/// buffers.
///
/// A thread that waited goes on a little after what it waited for: the machine's scheduler.
class VirtualRelay {
 public:
  /// Hands bytes to a link. @return how many it took
  using Write = std::function<std::size_t(std::span<const std::uint8_t>, base::RunTime)>;
  /// Hears each packet when it is read from a link.
  using OnPacket = std::function<void(casd::LinkId from, const mav::PacketView&, base::RunTime)>;

  explicit VirtualRelay(const casd::Topology& topology, WakeUp wake_up);
  VirtualRelay(const VirtualRelay&) = delete;
  VirtualRelay& operator=(const VirtualRelay&) = delete;

  /// @throws base::ConfigError when the topology has no link of that name
  casd::LinkId link(const std::string& name) const;
  void connect(casd::LinkId link, Write write);
  void on_packet(OnPacket callback) { on_packet_ = std::move(callback); }

  /// Bytes that came in on a link.
  void receive(casd::LinkId from, std::span<const std::uint8_t> bytes, base::RunTime now);
  /// Does what time alone makes due.
  void run(base::RunTime now);
  /// The next moment at which `run` has something to do.
  base::RunTime next_event() const;

  /// Killed: what waits in it is lost, what comes to it goes nowhere. What the commander knows of
  /// the vehicle outlives that.
  void kill();
  /// Started again.
  void restart() { running_ = true; }

  casd::VehicleCommander& commander() { return commander_; }
  /// HIL packets as they passed a link.
  const casd::LinkLedger& ledger(casd::LinkId link) const { return ports_[link].ledger; }

 private:
  struct Port {
    explicit Port(const casd::LinkConfig& config);
    bool is_line = false;  ///< a stream with a rate, not datagrams
    std::size_t inbox_bytes;
    casd::TxQueue queue;
    casd::LinePacer pacer;
    Write write;
    std::vector<std::uint8_t> tail;  ///< of a packet that the link has taken in part
    mav::PacketParser parser;
    std::deque<std::uint8_t> inbox;  ///< threads: blocking: what the kernel holds
    bool waited = false;             ///< the same: for the rest of the packet that is being read
    casd::LinkLedger ledger;
    std::optional<base::RunTime> carry_on_at;  ///< the thread waits for the pacer until then
  };
  enum class Phase { kTakeDatagrams, kReadLines, kWriteLines };

  void take(casd::LinkId from, std::span<const std::uint8_t> bytes, base::RunTime now);
  void route(casd::LinkId from, const mav::PacketView& packet, base::RunTime now);
  void send_own(std::span<const std::uint8_t> bytes);
  void pump(Port& port, base::RunTime now);
  void carry_on(base::RunTime now);
  void handle_arrivals(base::RunTime now);
  bool write_packet(Port& port, base::RunTime now);
  bool write_tail(Port& port, base::RunTime now);

  void serve(base::RunTime now);
  bool anything_to_do() const;
  void take_datagrams(base::RunTime now);
  bool read_lines(base::RunTime now);
  void write_lines(base::RunTime now);

  const bool blocking_;
  const bool single_;
  const casd::LineDrain drain_;
  bool running_ = true;
  WakeUp wake_up_;
  casd::LinkSlots slots_;
  casd::Router router_;
  std::vector<Port> ports_;
  casd::VehicleCommander commander_;
  mav::PacketParser own_parser_;
  OnPacket on_packet_;
  base::RunTime now_{};
  base::RunTime next_tick_{};
  base::RunTime next_second_{};

  // threads: per_link, single: what a thread that has been woken will find.
  struct Arrival {
    base::RunTime handled_at;
    casd::LinkId from;
    std::vector<std::uint8_t> bytes;
  };
  std::deque<Arrival>& thread_of(casd::LinkId link) { return threads_[single_ ? 0 : link]; }
  std::vector<std::deque<Arrival>> threads_;

  // threads: blocking
  Phase phase_ = Phase::kTakeDatagrams;
  base::RunTime busy_until_{};               ///< the thread waits for a line
  std::optional<base::RunTime> give_up_at_;  ///< the thread waits for the rest of a packet
};

}  // namespace cas::hils
