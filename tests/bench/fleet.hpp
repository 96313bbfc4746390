// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "base/rpc/client.hpp"
#include "base/time/clock.hpp"
#include "mavlink_gen/runtime/encode.hpp"
#include "tests/support/packet_stream.hpp"
#include "tests/support/udp_peer.hpp"

namespace cas::test {

/// What a fleet sends.
struct FleetLoad {
  static constexpr int kMostKinds = 10;

  int vehicles = 100;
  int stations = 4;
  double hz = 50;  ///< packets of each vehicle
  double seconds = 10;
  int kinds = 1;  ///< of messages, one after the other

  int packets() const { return static_cast<int>(hz * seconds); }  ///< of each vehicle
};

/// Vehicles and stations at the ends of casd's links, each on a UDP link of its own. Every packet
/// has a number, so that each is counted at each station. One thread may send while another reads.
class Fleet {
 public:
  explicit Fleet(const FleetLoad& load);

  /// @param command    port for calls; 0: a free one
  /// @param link_keys  of each link: ", queue: {...}"
  std::string topology(std::uint16_t command, const std::string& link_keys = "") const;
  /// Tells each vehicle where casd hears it. @return whether all links are up
  bool meet(base::rpc::Client& casd);

  /// Sends the packets that are due: all are on an even grid that begins with the first call.
  /// @return whether nothing is left
  bool send_due(base::RunTime now);
  /// When the next packet is due.
  base::RunTime next_due() const;
  /// Reads the stations' sockets.
  void read(base::RunTime now);

  /// Packets of all vehicles.
  std::size_t total() const;
  /// Packets that have not come, by station.
  std::vector<std::size_t> missing() const;
  /// Packets that came to a station a second time.
  std::size_t repeated() const { return repeated_; }
  /// From sending to reading, over all stations. @param q  0 to 1
  double delay_us(double q) const;

 private:
  struct Vehicle {
    explicit Vehicle(int number) : encoder({static_cast<std::uint8_t>(1 + number), 1}) {}
    UdpPeer socket;
    mav::Encoder encoder;
  };
  struct Station {
    UdpPeer socket;
    PacketStream stream;
    std::vector<std::int64_t> delay_ns;  ///< by packet; below 0: it has not come
  };
  std::size_t slot(std::size_t vehicle, std::uint32_t number) const;

  FleetLoad load_;
  std::vector<std::unique_ptr<Vehicle>> vehicles_;
  std::vector<std::unique_ptr<Station>> stations_;
  std::vector<std::atomic<std::int64_t>> sent_ns_;  ///< when, by packet
  base::RunTime begin_{};
  std::size_t turn_ = 0;  ///< packets sent
  std::size_t repeated_ = 0;
};

}  // namespace cas::test
