// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <thread>

#include "base/os/descriptor.hpp"
#include "base/os/mutex.hpp"
#include "hils/firmware/companion_station.hpp"

namespace cas::hils {

/// A CompanionStation on a UDP socket of its own, with a thread: setpoints keep coming while the
/// pilot waits for an answer.
class CompanionLink {
 public:
  /// Binds 127.0.0.1 with a free port, and is silent. @throws base::ConfigError
  CompanionLink();
  ~CompanionLink();
  CompanionLink(const CompanionLink&) = delete;
  CompanionLink& operator=(const CompanionLink&) = delete;

  /// Where casd's link sends to.
  std::uint16_t port() const { return port_; }
  /// Begins to talk with a vehicle by casd's port; what others send is not heard.
  /// @throws base::ConfigError
  void connect(std::uint16_t casd_port, mav::Source vehicle);
  bool connected() const { return thread_.joinable(); }

  /// Asks the station, or tells it something, between two of its packets. Only when connected.
  template <class Ask>
  auto with_station(Ask&& ask) {
    base::MutexLock lock(mutex_);
    return ask(*station_);
  }

 private:
  void run();

  base::Descriptor socket_;
  base::Descriptor stop_;
  std::uint16_t port_ = 0;
  base::Mutex mutex_;
  std::optional<CompanionStation> station_ CAS_GUARDED_BY(mutex_);
  std::thread thread_;
};

}  // namespace cas::hils
