// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <netinet/in.h>
#include <sys/socket.h>

#include <cstddef>
#include <span>

#include "casd/packet/packet_port.hpp"

namespace cas::casd {

/// Sends packets over a UDP socket, one datagram each, in as few system calls as it can: runs of
/// equal length go down the kernel's stack as one block that is cut into datagrams at its end (UDP
/// segmentation offload), everything else in one sendmmsg.
class DatagramSender {
 public:
  struct Result {
    std::size_t packets = 0;  ///< gone, or refused by the peer alone
    int error = 0;            ///< why it stopped: EAGAIN, or what broke; 0 when all are gone
  };

  /// @param to  nullptr for a connected socket
  Result send(int fd, std::span<const PacketRef> packets, const sockaddr* to, socklen_t to_size);

 private:
  std::size_t run_length(std::span<const PacketRef> packets) const;
  int send_run(int fd, std::span<const PacketRef> packets, const sockaddr* to, socklen_t to_size);
  static std::ptrdiff_t send_each(int fd, std::span<const PacketRef> packets, const sockaddr* to,
                                  socklen_t to_size);

  bool segmentation_ = true;  ///< until the kernel or the device refuses it
};

}  // namespace cas::casd
