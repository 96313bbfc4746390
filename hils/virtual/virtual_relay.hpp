// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/random.hpp"
#include "base/time/clock.hpp"
#include "casd/counters/link_counters.hpp"
#include "casd/link/blocking_tx_port.hpp"
#include "casd/link/ingress.hpp"
#include "casd/link/switchboard.hpp"
#include "casd/link/tx_port.hpp"
#include "casd/queue/line_timing.hpp"
#include "casd/station/vehicle_commander.hpp"
#include "casd/topology/routing_plan.hpp"
#include "casd/topology/topology.hpp"
#include "casd/transport/local_endpoint.hpp"
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

/// casd without sockets and threads, moved by the virtual clock. Packets take casd's own way from
/// the bytes to the ports; the threads and their reads are modelled. Computing takes no time; lines
/// do.
///
///   receive() --> Ingress of the link --> Switchboard --> TxPort of each destination --> write
///                                              +--> LocalEndpoint --> VehicleCommander
///
/// threads: auto, per_link and single differ in the wake-ups alone: none waits for a line, and a
/// link that floods stays with the others. With threads: blocking the one thread takes, in each
/// turn, all waiting datagrams, reads each line (waiting for the rest of a packet that has begun)
/// and lets each paced port write a packet and wait for its line; bytes that arrive meanwhile stay
/// in the kernel's buffers.
///
/// A waiting thread goes on a little after its event: the delay of the machine's scheduler.
class VirtualRelay final : private casd::LineWait {
 public:
  /// Hands bytes to a link. It must not call receive(). @return how many it took
  using Write = std::function<std::size_t(std::span<const std::uint8_t>, base::RunTime)>;
  /// Called for each packet that is read from a link.
  using OnPacket = std::function<void(casd::LinkId from, const mav::PacketView&, base::RunTime)>;

  VirtualRelay(const casd::Topology& topology, WakeUp wake_up);
  VirtualRelay(const VirtualRelay&) = delete;
  VirtualRelay& operator=(const VirtualRelay&) = delete;
  ~VirtualRelay() { local_->let_go(); }

  /// @throws base::ConfigError when the topology has no link of that name
  casd::LinkId link(const std::string& name) const;
  void connect(casd::LinkId link, Write write);
  void on_packet(OnPacket callback) { on_packet_ = std::move(callback); }

  /// Bytes that came in on a link.
  void receive(casd::LinkId from, std::span<const std::uint8_t> bytes, base::RunTime now);
  /// Does the work that time alone makes due.
  void run(base::RunTime now);
  /// The next moment at which `run` has something to do.
  base::RunTime next_event() const;

  /// Plays a killed casd: queued and arriving packets are lost. The commander keeps its state of
  /// the vehicles.
  void kill();
  /// Started again.
  void restart();

  /// From now on nothing of casd's own station leaves, or again.
  void silence(bool silent) { silent_ = silent; }
  /// Other delays from now on.
  void set_wake_up(WakeUp wake_up) { wake_up_ = wake_up; }

  casd::VehicleCommander& commander() { return commander_; }
  /// HIL packets as they passed a link.
  const casd::LinkLedger& ledger(casd::LinkId link) const { return *ports_[link].counters->ledger; }

 private:
  struct Port {
    Port(const casd::LinkConfig& config, casd::LinkId id, casd::Switchboard& switchboard);
    bool is_line = false;  ///< a stream with a rate, not datagrams
    std::size_t inbox_bytes;
    std::shared_ptr<casd::LinkCounters> counters;
    std::unique_ptr<casd::Ingress> ingress;
    casd::Parser parser;
    std::shared_ptr<casd::TxPort> tx;
    Write write;
    // threads: blocking: the kernel's buffer.
    std::deque<std::uint8_t> inbox;  ///< of a line
    std::deque<std::vector<std::uint8_t>> datagrams;
    std::size_t datagram_bytes = 0;
    bool is_empty() const { return inbox.empty() && datagrams.empty(); }
    bool waited = false;  ///< the same: for the rest of the packet that is being read
    std::optional<base::RunTime> carry_on_at;  ///< the thread waits for the pacer until then
  };
  enum class Phase { kTakeDatagrams, kReadLines, kWriteLines };

  void take(casd::LinkId from, std::span<const std::uint8_t> bytes, base::RunTime now);
  void send_own(std::span<const std::uint8_t> packet, std::span<const casd::Path> to);
  void hear(base::RunTime now);
  void wait_for_pacers();
  void wait_for_pacer(Port& port);
  void carry_on(base::RunTime now);
  void handle_arrivals(base::RunTime now);

  // LineWait, threads: blocking:
  base::RunTime now() const override { return now_; }
  void until(base::RunTime when) override;
  void for_room(int descriptor, base::Duration at_most) override;

  void serve(base::RunTime now);
  bool anything_to_do() const;
  base::RunTime next_turn() const;
  void take_datagrams(base::RunTime now);
  bool read_lines(base::RunTime now);
  void write_lines();

  const bool blocking_;
  const bool single_;
  bool running_ = true;
  bool silent_ = false;  ///< casd's own station
  WakeUp wake_up_;
  casd::LinkSlots slots_;
  casd::Switchboard switchboard_;
  std::vector<Port> ports_;
  std::shared_ptr<casd::LocalEndpoint> local_;
  casd::VehicleCommander commander_;
  bool hearing_ = false;  ///< packets are being handed to the commander
  bool hear_again_ = false;
  OnPacket on_packet_;
  base::RunTime now_{};  ///< threads: blocking: of the one thread, while it has its turn
  base::RunTime next_tick_{};
  base::RunTime next_second_{};

  // threads: auto, per_link, single: bytes that a thread takes when it has woken.
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
