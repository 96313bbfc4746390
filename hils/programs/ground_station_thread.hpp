// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <cstdint>
#include <thread>
#include <vector>

#include "base/os/descriptor.hpp"
#include "hils/programs/ground_station.hpp"

namespace cas::hils {

/// A GroundStation on a UDP socket of its own, with a thread, for runs in real time.
class GroundStationThread {
 public:
  /// Binds 127.0.0.1 with a free port; answers to whoever wrote last. @throws base::ConfigError
  explicit GroundStationThread(std::vector<std::uint8_t> systems);
  ~GroundStationThread();
  GroundStationThread(const GroundStationThread&) = delete;
  GroundStationThread& operator=(const GroundStationThread&) = delete;

  /// Sends so many packets a second besides, as GroundStation does; 0: none.
  void flood(double packets_hz) { flood_hz_ = packets_hz; }
  std::uint16_t port() const { return port_; }

 private:
  void run();

  base::Descriptor socket_;
  base::Descriptor stop_;
  std::uint16_t port_ = 0;
  std::vector<std::uint8_t> systems_;
  std::atomic<double> flood_hz_{0};
  std::thread thread_;
};

}  // namespace cas::hils
