// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/uio.h>
#include <time.h>

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/time/clock.hpp"
#include "casd/link/link.hpp"
#include "casd/packet/packet_port.hpp"
#include "casd/transport/socket_address.hpp"

namespace cas::casd {

/// Reads datagrams, up to 32 with one system call.
///
/// One that comes alone is read alone: the kernel's look for a second one is not free. After a
/// moment's work, or if it has waited itself, others may wait behind it, and are read with it.
///
/// The first of a read may have any size. The others have little room until the first large one
/// came: MAVLink's packets are small, and few senders pack many into one datagram.
class DatagramReader {
 public:
  static constexpr std::size_t kBatch = 32;
  static constexpr std::size_t kLargest = 65536;
  static constexpr std::size_t kUsual = 4096;
  /// A shorter wait in the socket is the machine's, and not told.
  static constexpr base::Duration kPrompt = std::chrono::milliseconds(5);

  /// Datagrams that come closer than this may lie in the socket together.
  static constexpr base::Duration kSoon = std::chrono::microseconds(300);

  /// @param socket  its number among those of the link
  explicit DatagramReader(std::uint8_t socket = 0);
  /// @param now  not later than this call
  /// @return how many came; 0: none waits; -1 with errno: the socket is of no more use
  int read(int fd, base::RunTime now);
  std::span<const std::uint8_t> datagram(std::size_t index) const;
  const PeerAddress& sender(std::size_t index) const { return senders_[index]; }
  /// How long the datagram lay in the socket, by the kernel's stamp; 0 when all came promptly. The
  /// stamp is wall-clock time: a step back of that clock makes what lies in the socket just then
  /// young, a step ahead ages it by no more than the time since the socket was last seen empty or
  /// the datagram before it came.
  base::Duration waited(std::size_t index) const {
    return late_ ? wait_of(index) : base::Duration{};
  }
  /// Datagrams that the kernel has thrown away for lack of room since the socket was opened.
  std::uint32_t kernel_drops() const { return kernel_drops_; }
  /// Bytes of datagrams for which there was no room, since the last call.
  std::uint64_t take_cut_bytes() { return std::exchange(cut_bytes_, 0); }
  /// Sent packets that the peer has refused, as a read learned since the last call.
  std::uint64_t take_refused() { return std::exchange(refused_, 0); }
  /// Counts the first datagram of each read.
  Arrivals arrivals() const { return arrivals_; }

 private:
  void note_drops(const msghdr& header);
  base::Duration note_wait(base::RunTime now);
  int take(int fd, std::size_t most);
  void compare_clocks();
  void offer(std::size_t index);
  void give_room(std::size_t bytes);
  void note_size(std::size_t index);
  base::Duration wait_of(std::size_t index) const;

  static constexpr std::size_t kControlBytes =
      CMSG_SPACE(sizeof(std::uint32_t)) + CMSG_SPACE(sizeof(timespec));
  std::vector<std::uint8_t> first_;
  std::vector<std::uint8_t> others_;
  std::size_t room_ = 0;  ///< of each of the others
  bool large_ = false;    ///< a datagram came that is larger than room_
  std::uint64_t cut_bytes_ = 0;
  std::array<mmsghdr, kBatch> messages_{};
  std::array<iovec, kBatch> parts_{};
  std::array<PeerAddress, kBatch> senders_{};
  alignas(cmsghdr) std::array<std::array<char, kControlBytes>, kBatch> control_{};
  std::size_t used_ = kBatch;  ///< messages whose lengths are not what they offer room for
  std::uint32_t kernel_drops_ = 0;
  std::uint64_t refused_ = 0;
  base::Duration read_at_{};     ///< wall-clock time
  base::Duration wall_ahead_{};  ///< wall-clock time less ours, when they were last compared
  base::RunTime compared_at_{};
  base::RunTime read_last_ = base::RunTime::max();  ///< when something came
  base::RunTime empty_at_{};                        ///< what waits in the socket came after this
  base::Duration longest_{};  ///< longest possible wait of the newest read's datagrams
  bool late_ = false;         ///< the oldest one had waited
  Arrivals arrivals_;
};

/// Opens a UDP socket for `family`: non-blocking, close-on-exec, a receive buffer for some 40 ms of
/// flood, drops counted, datagrams stamped. @param interface  device to bind to, or empty. @return
/// -1 with errno
int open_udp_socket(int family, const std::string& interface);

/// Sends packets over a UDP socket, one datagram each, in as few system calls as it can: runs of
/// equal length go down the kernel's stack as one block that is cut into datagrams at its end (UDP
/// segmentation offload), everything else in one sendmmsg.
class DatagramSender {
 public:
  struct Result {
    std::size_t packets = 0;  ///< sent or refused
    /// Indices of `packets` that the peer or the network does not take now, rising; good until the
    /// next call.
    std::span<const std::size_t> refused = {};
    int refusal = 0;                    ///< why the last of `refused` was
    std::uint64_t refused_earlier = 0;  ///< packets of earlier calls that the peer has refused
    int error = 0;  ///< why it stopped: EAGAIN, or what broke; 0 when all are through
  };

  /// @param to  nullptr for a connected socket
  Result send(int fd, std::span<const PacketRef> packets, const sockaddr* to, socklen_t to_size);

 private:
  std::size_t run_length(std::span<const PacketRef> packets) const;
  std::ptrdiff_t send_run(int fd, std::span<const PacketRef> packets, const sockaddr* to,
                          socklen_t to_size);
  std::ptrdiff_t send_singly(int fd, std::span<const PacketRef> packets, const sockaddr* to,
                             socklen_t to_size);

  bool segmentation_ = true;  ///< until the kernel or the device refuses it
  std::vector<std::size_t> refused_;
};

}  // namespace cas::casd
