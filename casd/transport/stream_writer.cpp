// SPDX-License-Identifier: BSD-3-Clause
#include "casd/transport/stream_writer.hpp"

#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/uio.h>

#include <array>
#include <cerrno>

namespace cas::casd {
namespace {

constexpr std::size_t kMaxParts = 64;

// Bytes that the driver has not yet put on the line; 0 where it cannot tell.
std::size_t unsent_bytes(int fd) {
  int bytes = 0;
  return ::ioctl(fd, TIOCOUTQ, &bytes) == 0 && bytes > 0 ? static_cast<std::size_t>(bytes) : 0;
}

bool is_transient(int error) { return error == EAGAIN || error == EWOULDBLOCK || error == EINTR; }

// Describes the packets as few parts as possible: what lies end to end in memory is one part.
// @return how many packets the parts hold
std::size_t gather(std::span<const PacketRef> packets, std::array<iovec, kMaxParts>& parts,
                   std::size_t& part_count, std::size_t& bytes) {
  part_count = 0;
  bytes = 0;
  std::size_t taken = 0;
  for (; taken < packets.size(); ++taken) {
    auto* const data = const_cast<std::uint8_t*>(packets[taken].bytes.data());
    const std::size_t size = packets[taken].bytes.size();
    const bool adjoins =
        part_count > 0 && static_cast<std::uint8_t*>(parts[part_count - 1].iov_base) +
                                  parts[part_count - 1].iov_len ==
                              data;
    if (adjoins) {
      parts[part_count - 1].iov_len += size;
    } else {
      if (part_count == kMaxParts) break;
      parts[part_count++] = {data, size};
    }
    bytes += size;
  }
  return taken;
}

}  // namespace

WriteResult StreamWriter::write(std::span<const PacketRef> packets) {
  WriteResult result;
  while (result.packets < packets.size()) {
    std::array<iovec, kMaxParts> parts;
    std::size_t part_count = 0;
    std::size_t bytes = 0;
    const auto left = packets.subspan(result.packets);
    const std::size_t taken = gather(left, parts, part_count, bytes);
    const std::ptrdiff_t gone = write_vector(parts.data(), part_count);
    if (gone < 0) {
      result.broken = true;
      return result;
    }
    if (static_cast<std::size_t>(gone) == bytes) {
      result.packets += taken;
      continue;
    }
    // Short: find the packet that was begun.
    std::size_t counted = static_cast<std::size_t>(gone);
    for (const PacketRef& packet : left) {
      if (counted < packet.bytes.size()) break;
      counted -= packet.bytes.size();
      ++result.packets;
    }
    result.part_of_next = counted;
    return result;
  }
  return result;
}

std::ptrdiff_t StreamWriter::write_rest(std::span<const std::uint8_t> bytes) {
  iovec part{const_cast<std::uint8_t*>(bytes.data()), bytes.size()};
  return write_vector(&part, 1);
}

std::size_t StreamWriter::unsent() const {
  return kind_ == Kind::kSerial ? unsent_bytes(descriptor_.get()) : 0;
}

// @return bytes gone, 0 when there is no room, -1 when the descriptor is of no more use
std::ptrdiff_t StreamWriter::write_vector(iovec* parts, std::size_t count) {
  std::ptrdiff_t gone = 0;
  if (kind_ == Kind::kSocket) {
    msghdr message{};
    message.msg_iov = parts;
    message.msg_iovlen = count;
    gone = ::sendmsg(descriptor_.get(), &message, MSG_NOSIGNAL | MSG_DONTWAIT);
  } else if (count == 1) {
    gone = ::write(descriptor_.get(), parts->iov_base, parts->iov_len);
  } else {
    gone = ::writev(descriptor_.get(), parts, static_cast<int>(count));
  }
  if (gone >= 0) return gone;
  return is_transient(errno) ? 0 : -1;
}

}  // namespace cas::casd
