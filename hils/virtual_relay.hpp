// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "base/clock.hpp"
#include "casd/line_pacer.hpp"
#include "casd/router.hpp"
#include "casd/topology.hpp"
#include "casd/tx_queue.hpp"
#include "casd/vehicle_commander.hpp"
#include "mavlink_gen/runtime/packet_parser.hpp"

namespace cas::hils {

/// casd without sockets and threads: its own router, queues, pacers and ground station, moved by
/// the virtual clock. Forwarding itself takes no time.
///
///   receive() --> parser --> Router --> queue of each destination --> pacer --> write
///                              +--> own station (VehicleCommander)
class VirtualRelay {
 public:
  /// Hands bytes to a link. @return how many it took
  using Write = std::function<std::size_t(std::span<const std::uint8_t>, base::RunTime)>;
  /// Hears each packet that came in on a link.
  using OnPacket = std::function<void(casd::LinkId from, const mav::PacketView&, base::RunTime)>;

  explicit VirtualRelay(const casd::Topology& topology);
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

  casd::VehicleCommander& commander() { return commander_; }
  /// Packets dropped towards a link, by cause.
  const std::array<std::uint64_t, casd::kDropCauses>& dropped(casd::LinkId link) const {
    return ports_[link].dropped;
  }

 private:
  struct Port {
    casd::TxQueue queue;
    casd::LinePacer pacer;
    Write write;
    std::vector<std::uint8_t> tail;  ///< of a packet that the link has taken in part
    std::array<std::uint64_t, casd::kDropCauses> dropped{};
    mav::PacketParser parser;
    explicit Port(const casd::LinkConfig& config);
  };

  void route(casd::LinkId from, const mav::PacketView& packet, base::RunTime now);
  void send_own(std::span<const std::uint8_t> bytes);
  void pump(Port& port, base::RunTime now);
  bool write_tail(Port& port, base::RunTime now);

  casd::LinkSlots slots_;
  casd::Router router_;
  std::vector<Port> ports_;
  casd::VehicleCommander commander_;
  mav::PacketParser own_parser_;
  OnPacket on_packet_;
  base::RunTime now_{};
  base::RunTime next_tick_{};
  base::RunTime next_second_{};
};

}  // namespace cas::hils
