// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <vector>

#include "plugins/common/inet_address.hpp"
#include "plugins/mavlink_interface/hil_port.hpp"

namespace cas::sim {

/// Packets over the TCP connection that a flight controller opens: PX4's simulator API, in which
/// the simulator listens. One controller at a time; the next is served when that one has gone, and
/// waits in the listen queue until then. A client whose first byte begins no packet, such as a
/// browser, is closed and nothing of it is handed on; one that says nothing for 5 s goes when
/// another waits.
///
/// Never blocks: a packet that the connection does not take is dropped whole and counted, so that
/// the byte stream stays intact.
class TcpServerPort final : public HilPort {
 public:
  /// A flight controller speaks at once; so long may one be silent while another waits.
  static constexpr base::Duration kPatience = std::chrono::seconds(5);

  /// @throws std::system_error when the address cannot be bound
  explicit TcpServerPort(const InetAddress& local, base::Duration patience = kPatience);
  ~TcpServerPort() override;
  TcpServerPort(const TcpServerPort&) = delete;
  TcpServerPort& operator=(const TcpServerPort&) = delete;

  bool send(std::span<const std::uint8_t> packet) override;
  void poll(const OnBytes& on_bytes) override;
  bool wait(base::Duration timeout) override;
  base::RunTime now() const override { return base::steady_now(); }
  std::uint64_t peers() const override { return connections_; }
  bool connected() const override { return client_ >= 0; }
  std::string endpoint() const override;
  void add_figures(nlohmann::ordered_json& figures) const override;

 private:
  void accept_client();
  void drop_client(const char* why);
  void refuse_client();
  /// Drops a client that has never said anything, if another one waits.
  void yield_place();
  /// Sends the unsent rest of an earlier packet. @return whether nothing is left
  bool flush_tail();

  static constexpr std::size_t kReadBytes = 16384;

  base::Duration patience_;
  int listener_ = -1;
  int client_ = -1;
  std::array<std::uint8_t, kReadBytes> buffer_;
  std::vector<std::uint8_t> tail_;  // rest of a packet that was taken in part
  base::RunTime accepted_{};        ///< the client
  bool speaks_mavlink_ = false;     ///< the client's first byte has come and begins a packet
  std::uint64_t connections_ = 0;
  std::uint64_t refused_clients_ = 0;
  std::uint64_t sent_packets_ = 0;
  std::uint64_t without_peer_ = 0;
  std::uint64_t queue_full_ = 0;
};

}  // namespace cas::sim
