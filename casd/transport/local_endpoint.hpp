// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <span>

#include "base/os/mutex.hpp"
#include "casd/link/ingress.hpp"
#include "casd/link/link_loop.hpp"
#include "casd/packet/packet_port.hpp"
#include "casd/packet/packet_ring.hpp"

namespace cas::casd {

class Station;

/// casd's own station as a link of the router. Packets for it wait in a bounded queue for casd's
/// main thread; packets from it enter the router like any other link's.
class LocalEndpoint final : public PacketPort {
 public:
  LocalEndpoint(Switchboard& switchboard, mav::Source self);

  /// From any link's thread: queues what is for casd or for everybody, and what others have a
  /// vehicle do.
  void deliver(std::span<const PacketRef> packets, base::RunTime now) override;

  // casd's main thread:

  /// Whether every packet wakes the main thread (as at first), or only those that are addressed to
  /// casd itself; the others wait until it dispatches.
  void wake_for_all(bool all);

  /// Becomes readable when packets wait.
  int descriptor() const { return signal_.descriptor().get(); }
  /// Gives the station what waits.
  void dispatch(Station& station, base::RunTime now);
  /// Sends a packet of the station. Anything but one whole packet is refused.
  /// @param to  paths to the one vehicle that it is for; empty: it goes where its target was heard
  bool send(std::span<const std::uint8_t> packet, std::span<const Path> to, base::RunTime now);
  /// Keeps the station's route alive: once a second.
  void tick(base::RunTime now) { ingress_.tick(now); }
  /// Drops the table of ports, which holds this endpoint too. Nothing is sent from here on.
  void let_go() { ingress_.let_go(); }

 private:
  static constexpr std::size_t kQueueBytes = 1024 * 1024;

  bool concerns_us(const PacketInfo& info) const;

  mav::Source self_;
  std::shared_ptr<LinkCounters> counters_;
  Ingress ingress_;
  WakeSignal signal_;
  base::Mutex mutex_;
  PacketRing waiting_ CAS_GUARDED_BY(mutex_);
  bool raised_ CAS_GUARDED_BY(mutex_) = false;  ///< `signal_` has not been lowered since
  bool wakes_for_all_ CAS_GUARDED_BY(mutex_) = true;
  PacketRing dispatching_;
};

}  // namespace cas::casd
