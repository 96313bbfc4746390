// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <optional>

#include "base/config/config.hpp"
#include "plugins/common/inet_address.hpp"
#include "plugins/mavlink_interface/hil_port.hpp"

namespace cas::sim {

/// Packets over UDP, one per datagram out, any number per datagram in.
///
/// Everything happens on the simulation's thread, without a thread of its own: a step applies
/// packets that arrived before it, so a second thread could only add a wake-up. The moment of
/// arrival is the kernel's (SO_TIMESTAMPNS), so it does not depend on when the step looks.
class UdpPort final : public HilPort {
 public:
  /// @param remote  only accepted source; nullopt: the first sender, from then on
  UdpPort(const base::ConfigNode& local, const std::optional<base::ConfigNode>& remote);
  ~UdpPort() override;
  UdpPort(const UdpPort&) = delete;
  UdpPort& operator=(const UdpPort&) = delete;

  bool send(std::span<const std::uint8_t> packet) override;
  void poll(const OnBytes& on_bytes) override;
  bool wait(base::Duration timeout) override;
  base::RunTime now() const override { return base::steady_now(); }
  std::string endpoint() const override;
  void add_figures(nlohmann::ordered_json& figures) const override;

 private:
  struct Batch;  // buffers of one recvmmsg

  /// @return datagrams read
  int read_batch(const OnBytes& on_bytes);
  bool has_datagram() const;
  bool is_from_peer(const InetAddress& source);

  int socket_ = -1;
  std::optional<InetAddress> peer_;
  std::unique_ptr<Batch> batch_;
  std::uint64_t sent_datagrams_ = 0;
  std::uint64_t received_datagrams_ = 0;
  std::uint64_t queue_full_ = 0;
  std::uint64_t send_errors_ = 0;
  std::uint64_t without_peer_ = 0;
  std::uint64_t foreign_ = 0;
  std::uint64_t cut_ = 0;
};

}  // namespace cas::sim
