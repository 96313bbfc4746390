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

#include "base/random.hpp"
#include "base/time/clock.hpp"
#include "casd/counters/link_ledger.hpp"
#include "casd/queue/line_timing.hpp"
#include "casd/queue/tx_queue.hpp"
#include "casd/routing/router.hpp"
#include "casd/station/vehicle_commander.hpp"
#include "casd/topology/routing_plan.hpp"
#include "casd/topology/topology.hpp"
#include "hils/scenario/scenario.hpp"
#include "mavlink_gen/runtime/packet_parser.hpp"

namespace cas::hils {

/// Draws wake-up delays; the same seed gives the same delays.
class WakeUp {
 public:
  WakeUp(const WakeUpFigures& figures, std::uint64_t seed);
  base::Duration draw();
  bool is_instant() const { return median_us_ <= 0; }

 private:
  double median_us_;
  double sigma_ = 0;  ///< of the logarithm
  base::NormalRandom random_;
};

/// casd without sockets and threads: its own router, queues, pacers and ground station, moved by
/// the virtual clock. Computing takes no time; lines do.
///
///   receive() --> parser --> Router --> queue of each destination --> pacer --> write
///                              +--> own station (VehicleCommander)
///
/// threads: per_link and single are the same here: neither waits for a line. With threads: blocking
/// the one thread is modelled: in each turn it takes all waiting datagrams, reads each
/// line (waiting for the rest of a packet that has begun) and writes one packet to each paced
/// line (waiting until the line has sent it); what arrives meanwhile stays in the kernel's
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

  /// Plays a killed casd: queued and arriving packets are lost. The commander keeps its state of
  /// the vehicles.
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
    std::deque<std::uint8_t> inbox;  ///< threads: blocking: bytes in the kernel's buffer
    bool waited = false;             ///< the same: for the rest of the packet that is being read
    casd::LinkLedger ledger;
    std::optional<base::RunTime> carry_on_at;  ///< the thread waits for the pacer until then
  };
  enum class Phase { kTakeDatagrams, kReadLines, kWriteLines };

  void take(casd::LinkId from, std::span<const std::uint8_t> bytes, base::RunTime now);
  void route(casd::LinkId from, const mav::PacketView& packet, base::RunTime now);
  void pass_on(casd::LinkId from, const casd::Route& route, const mav::PacketView& packet,
               base::RunTime now);
  void send_own(std::span<const std::uint8_t> bytes, std::span<const casd::Path> to);
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

  // threads: per_link, single: bytes that a thread takes when it has woken.
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
