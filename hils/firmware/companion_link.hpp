// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>

#include "base/os/mutex.hpp"
#include "hils/firmware/companion_station.hpp"
#include "hils/run/loopback_udp.hpp"
#include "hils/run/ticking_thread.hpp"

namespace cas::hils {

/// A CompanionStation on a UDP socket of its own, with a thread: setpoints keep coming while the
/// pilot waits for an answer.
class CompanionLink {
 public:
  /// Binds 127.0.0.1 with a free port, and is silent. @throws base::ConfigError
  CompanionLink();
  CompanionLink(const CompanionLink&) = delete;
  CompanionLink& operator=(const CompanionLink&) = delete;

  /// The port that casd's link sends to.
  std::uint16_t port() const { return socket_.port(); }
  /// Connects to a vehicle through casd's port; packets of other senders are ignored.
  /// @throws base::ConfigError
  void connect(std::uint16_t casd_port, mav::Source vehicle);
  bool connected() const { return thread_.has_value(); }

  /// Calls `ask` with the station between two of its packets. Only when connected.
  template <class Ask>
  auto with_station(Ask&& ask) {
    base::MutexLock lock(mutex_);
    return ask(*station_);
  }

 private:
  void look();

  base::Mutex mutex_;
  LoopbackUdp socket_;  ///< once connected, used under the mutex
  std::optional<CompanionStation> station_ CAS_GUARDED_BY(mutex_);
  std::optional<TickingThread> thread_;
};

}  // namespace cas::hils
