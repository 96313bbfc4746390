// SPDX-License-Identifier: BSD-3-Clause
#include "casd/transport/datagram_reader.hpp"

#include <net/if.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace cas::casd {
namespace {

// Room for some 2700 small datagrams: what a flood brings while a thread is not scheduled. It is
// emptied faster than any sender fills it, so nothing in it grows old.
constexpr int kReceiveBuffer_bytes = 2 * 1024 * 1024;

}  // namespace

DatagramReader::DatagramReader() : bytes_(kBatch * kMaxDatagram) {
  for (std::size_t i = 0; i < kBatch; ++i)
    parts_[i] = {bytes_.data() + i * kMaxDatagram, kMaxDatagram};
}

int DatagramReader::read(int fd) {
  for (std::size_t i = 0; i < kBatch; ++i) {
    msghdr& header = messages_[i].msg_hdr;
    header.msg_name = &senders_[i];
    header.msg_namelen = sizeof senders_[i];
    header.msg_iov = &parts_[i];
    header.msg_iovlen = 1;
    header.msg_control = control_[i].data();
    header.msg_controllen = kControlBytes;
  }
  const int count = ::recvmmsg(fd, messages_.data(), kBatch, MSG_DONTWAIT, nullptr);
  if (count > 0) {
    note_drops(messages_[static_cast<std::size_t>(count) - 1].msg_hdr);
    return count;
  }
  // A peer that is not there (yet) answers our packets with refusals: no trouble of the socket.
  const bool transient = errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR ||
                         errno == ECONNREFUSED || errno == EHOSTUNREACH || errno == ENETUNREACH;
  return transient ? 0 : -1;
}

std::span<const std::uint8_t> DatagramReader::datagram(std::size_t index) const {
  return {bytes_.data() + index * kMaxDatagram, messages_[index].msg_len};
}

void DatagramReader::note_drops(msghdr& header) {
  for (cmsghdr* item = CMSG_FIRSTHDR(&header); item != nullptr; item = CMSG_NXTHDR(&header, item)) {
    if (item->cmsg_level == SOL_SOCKET && item->cmsg_type == SO_RXQ_OVFL) {
      std::memcpy(&kernel_drops_, CMSG_DATA(item), sizeof kernel_drops_);
    }
  }
}

int open_udp_socket(int family, const std::string& interface) {
  const int fd = ::socket(family, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (fd < 0) return -1;
  const int on = 1;
  ::setsockopt(fd, SOL_SOCKET, SO_RXQ_OVFL, &on, sizeof on);
  const int size = kReceiveBuffer_bytes;
  if (::setsockopt(fd, SOL_SOCKET, SO_RCVBUFFORCE, &size, sizeof size) != 0) {
    ::setsockopt(fd, SOL_SOCKET, SO_RCVBUF, &size, sizeof size);
  }
  if (!interface.empty() && ::setsockopt(fd, SOL_SOCKET, SO_BINDTODEVICE, interface.c_str(),
                                         static_cast<socklen_t>(interface.size())) != 0) {
    const int error = errno;
    ::close(fd);
    errno = error;
    return -1;
  }
  return fd;
}

}  // namespace cas::casd
