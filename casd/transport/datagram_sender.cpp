// SPDX-License-Identifier: BSD-3-Clause
#include "casd/transport/datagram_sender.hpp"

#include <netinet/udp.h>
#include <sys/uio.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <utility>

namespace cas::casd {
namespace {

constexpr std::size_t kMaxRun = 64;    // segments of one block (UDP_MAX_SEGMENTS of old kernels)
constexpr std::size_t kWorthARun = 2;  // fewer packets go out singly
constexpr std::size_t kMaxBatch = 64;

// The answer to an earlier packet: nobody listened then. This one was not even tried.
bool concerns_earlier_packet(int error) { return error == ECONNREFUSED; }

// The peer's trouble, not the socket's: nobody listens there, or it cannot be reached now. The
// packet is lost as UDP packets are, the next one is tried as ever.
bool concerns_peer_only(int error) {
  switch (error) {
    case ECONNREFUSED:
    case EHOSTUNREACH:
    case ENETUNREACH:
    case EHOSTDOWN:
    case ENETDOWN:
    case EPERM:
    case EACCES:
      return true;
    default:
      return false;
  }
}

msghdr header_for(const sockaddr* to, socklen_t to_size, iovec* parts, std::size_t count) {
  msghdr header{};
  header.msg_name = const_cast<sockaddr*>(to);
  header.msg_namelen = to_size;
  header.msg_iov = parts;
  header.msg_iovlen = count;
  return header;
}

iovec part_of(const PacketRef& packet) {
  return {const_cast<std::uint8_t*>(packet.bytes.data()), packet.bytes.size()};
}

}  // namespace

DatagramSender::Result DatagramSender::send(int fd, std::span<const PacketRef> packets,
                                            const sockaddr* to, socklen_t to_size) {
  Result result;
  bool refused = false;
  while (result.packets < packets.size()) {
    const auto left = packets.subspan(result.packets);
    const std::size_t run = run_length(left);
    int error = 0;
    if (run >= kWorthARun) {
      error = send_run(fd, left.first(run), to, to_size);
      if (error == EIO || error == EINVAL || error == EOPNOTSUPP) {
        segmentation_ = false;
        continue;
      }
      if (error == 0) {
        result.packets += run;
        continue;
      }
    } else {
      // Up to where the next run begins.
      std::size_t count = 1;
      while (count < std::min(left.size(), kMaxBatch) &&
             run_length(left.subspan(count)) < kWorthARun) {
        ++count;
      }
      const std::ptrdiff_t sent = send_each(fd, left.first(count), to, to_size);
      if (sent > 0) {
        result.packets += static_cast<std::size_t>(sent);
        continue;
      }
      error = errno;
    }
    if (error == EINTR) continue;
    if (concerns_earlier_packet(error) && !std::exchange(refused, true)) continue;
    if (concerns_peer_only(error)) {
      result.packets += run >= kWorthARun ? run : 1;
      refused = false;
      continue;
    }
    result.error = error == EWOULDBLOCK || error == ENOBUFS ? EAGAIN : error;
    return result;
  }
  return result;
}

// Packets of equal length at the front; the last one may be shorter.
std::size_t DatagramSender::run_length(std::span<const PacketRef> packets) const {
  if (!segmentation_) return 1;
  const std::size_t length = packets.front().bytes.size();
  const std::size_t most = std::min(packets.size(), kMaxRun);
  std::size_t count = 1;
  while (count < most && packets[count].bytes.size() == length) ++count;
  if (count < most && packets[count].bytes.size() < length) ++count;
  return count;
}

int DatagramSender::send_run(int fd, std::span<const PacketRef> packets, const sockaddr* to,
                             socklen_t to_size) {
  std::array<iovec, kMaxRun> parts;
  for (std::size_t i = 0; i < packets.size(); ++i) parts[i] = part_of(packets[i]);
  msghdr header = header_for(to, to_size, parts.data(), packets.size());
  alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof(std::uint16_t))> control{};
  header.msg_control = control.data();
  header.msg_controllen = control.size();
  cmsghdr* const segment = CMSG_FIRSTHDR(&header);
  segment->cmsg_level = SOL_UDP;
  segment->cmsg_type = UDP_SEGMENT;
  segment->cmsg_len = CMSG_LEN(sizeof(std::uint16_t));
  const auto size = static_cast<std::uint16_t>(packets.front().bytes.size());
  std::memcpy(CMSG_DATA(segment), &size, sizeof size);
  return ::sendmsg(fd, &header, MSG_DONTWAIT | MSG_NOSIGNAL) >= 0 ? 0 : errno;
}

// @return datagrams sent; 0 or less with errno when not even the first
std::ptrdiff_t DatagramSender::send_each(int fd, std::span<const PacketRef> packets,
                                         const sockaddr* to, socklen_t to_size) {
  if (packets.size() == 1) {
    const auto bytes = packets.front().bytes;
    const auto sent =
        ::sendto(fd, bytes.data(), bytes.size(), MSG_DONTWAIT | MSG_NOSIGNAL, to, to_size);
    return sent < 0 ? -1 : 1;
  }
  std::array<iovec, kMaxBatch> parts;
  std::array<mmsghdr, kMaxBatch> messages;
  for (std::size_t i = 0; i < packets.size(); ++i) {
    parts[i] = part_of(packets[i]);
    messages[i] = {header_for(to, to_size, &parts[i], 1), 0};
  }
  return ::sendmmsg(fd, messages.data(), static_cast<unsigned>(packets.size()),
                    MSG_DONTWAIT | MSG_NOSIGNAL);
}

}  // namespace cas::casd
