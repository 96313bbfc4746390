// SPDX-License-Identifier: BSD-3-Clause
#include "casd/transport/udp_socket.hpp"

#include <net/if.h>
#include <netinet/udp.h>
#include <sys/uio.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <optional>
#include <utility>

namespace cas::casd {
namespace {

constexpr std::size_t kMaxRun = 64;    // segments of one block (UDP_MAX_SEGMENTS of old kernels)
constexpr std::size_t kWorthARun = 2;  // fewer packets go out singly
constexpr std::size_t kMaxBatch = 64;

// The kernel or the device cannot cut a block into datagrams.
bool refuses_segmentation(int error) {
  return error == EIO || error == EINVAL || error == EOPNOTSUPP;
}

// The answer to an earlier packet, which no socket took. This one was not even tried.
bool concerns_earlier_packet(int error) { return error == ECONNREFUSED; }

// The peer's trouble, not the socket's: it does not listen or cannot be reached now. The
// packet is lost, the next one is tried as ever.
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

// Whether ICMP reported an earlier packet as refused: nobody listens, or there is no route.
bool is_refusal(int error) {
  return error == ECONNREFUSED || error == EHOSTUNREACH || error == ENETUNREACH;
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

// Room for some 2700 small datagrams: what a flood brings while a thread is not scheduled. It is
// emptied faster than any sender fills it, so nothing in it grows old.
constexpr int kReceiveBuffer_bytes = 2 * 1024 * 1024;

// While a stamp lies this close to our estimate of the wall clock, the estimate is kept for a
// second; beyond it the clock was set or the datagram waited, and the clock is read.
constexpr base::Duration kCloseStamp = std::chrono::milliseconds(1);
constexpr base::Duration kEstimateHolds = std::chrono::seconds(1);

// More is not counted as arrival time: one late packet says nothing of a core.
constexpr base::Duration kMostArrival = std::chrono::microseconds(100);

base::Duration as_duration(const timespec& time) {
  return std::chrono::seconds(time.tv_sec) + std::chrono::nanoseconds(time.tv_nsec);
}

// The control message of this type that came with a datagram.
template <class Value>
std::optional<Value> control_value(const msghdr& header, int type) {
  auto& items = const_cast<msghdr&>(header);  // CMSG_NXTHDR only reads
  for (cmsghdr* item = CMSG_FIRSTHDR(&items); item != nullptr; item = CMSG_NXTHDR(&items, item)) {
    if (item->cmsg_level != SOL_SOCKET || item->cmsg_type != type) continue;
    Value value;
    std::memcpy(&value, CMSG_DATA(item), sizeof value);
    return value;
  }
  return std::nullopt;
}

}  // namespace

DatagramSender::Result DatagramSender::send(int fd, std::span<const PacketRef> packets,
                                            const sockaddr* to, socklen_t to_size) {
  Result result;
  bool tried_again = false;
  refused_.clear();
  while (result.packets < packets.size()) {
    const auto left = packets.subspan(result.packets);
    const std::size_t run = run_length(left);
    const bool as_run = run >= kWorthARun;
    const std::ptrdiff_t gone =
        as_run ? send_run(fd, left.first(run), to, to_size) : send_singly(fd, left, to, to_size);
    if (gone > 0) {
      result.packets += static_cast<std::size_t>(gone);
      tried_again = false;
      continue;
    }
    const int error = errno;
    if (as_run && refuses_segmentation(error)) {
      segmentation_ = false;
      continue;
    }
    if (error == EINTR) continue;
    if (concerns_earlier_packet(error) && !std::exchange(tried_again, true)) {
      ++result.refused_earlier;
      continue;
    }
    if (concerns_peer_only(error)) {
      result.refusal = error;
      for (std::size_t i = 0; i < (as_run ? run : 1); ++i) refused_.push_back(result.packets++);
      tried_again = false;
      continue;
    }
    result.error = error == EWOULDBLOCK || error == ENOBUFS ? EAGAIN : error;
    break;
  }
  result.refused = refused_;
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

// @return datagrams sent; -1 with errno
std::ptrdiff_t DatagramSender::send_run(int fd, std::span<const PacketRef> packets,
                                        const sockaddr* to, socklen_t to_size) {
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
  const bool sent = ::sendmsg(fd, &header, MSG_DONTWAIT | MSG_NOSIGNAL) >= 0;
  return sent ? static_cast<std::ptrdiff_t>(packets.size()) : -1;
}

// Up to where the next run begins. @return datagrams sent; 0 or less with errno when not even the
// first
std::ptrdiff_t DatagramSender::send_singly(int fd, std::span<const PacketRef> packets,
                                           const sockaddr* to, socklen_t to_size) {
  std::size_t count = 1;
  while (count < std::min(packets.size(), kMaxBatch) &&
         run_length(packets.subspan(count)) < kWorthARun) {
    ++count;
  }
  if (count == 1) {
    const auto bytes = packets.front().bytes;
    const auto sent =
        ::sendto(fd, bytes.data(), bytes.size(), MSG_DONTWAIT | MSG_NOSIGNAL, to, to_size);
    return sent < 0 ? -1 : 1;
  }
  std::array<iovec, kMaxBatch> parts;
  std::array<mmsghdr, kMaxBatch> messages;
  for (std::size_t i = 0; i < count; ++i) {
    parts[i] = part_of(packets[i]);
    messages[i] = {header_for(to, to_size, &parts[i], 1), 0};
  }
  return ::sendmmsg(fd, messages.data(), static_cast<unsigned>(count), MSG_DONTWAIT | MSG_NOSIGNAL);
}

DatagramReader::DatagramReader(std::uint8_t socket) : first_(kLargest) {
  parts_[0] = {first_.data(), first_.size()};
  give_room(kUsual);
  for (std::size_t i = 0; i < kBatch; ++i) {
    msghdr& header = messages_[i].msg_hdr;
    senders_[i].socket = socket;
    header.msg_name = &senders_[i].address.storage;
    header.msg_iov = &parts_[i];
    header.msg_iovlen = 1;
    header.msg_control = control_[i].data();
  }
}

// Discards the datagrams in the other buffers.
void DatagramReader::give_room(std::size_t bytes) {
  room_ = bytes;
  others_.resize((kBatch - 1) * room_);
  for (std::size_t i = 1; i < kBatch; ++i) {
    parts_[i] = {others_.data() + (i - 1) * room_, room_};
  }
}

int DatagramReader::read(int fd, base::RunTime now) {
  // The kernel has written the lengths of those that it filled.
  for (; used_ > 0; --used_) offer(used_ - 1);
  const std::size_t wanted = now - read_last_ < kSoon ? kBatch : 1;
  if (take(fd, wanted) > 0) {
    read_last_ = now;
    const base::Duration wait = note_wait(now);
    bool emptied = used_ < wanted;
    if (wanted == 1 && wait > kSoon) {
      const int most = static_cast<int>(kBatch) - 1;
      const int more = take(fd, kBatch - 1);
      emptied = more >= 0 ? more < most : errno == EAGAIN;
    }
    note_drops(messages_[used_ - 1].msg_hdr);
    // What comes next is younger than a socket that is empty, or than the last one out of it.
    empty_at_ = emptied ? now : std::max(empty_at_, now - wait_of(used_ - 1));
    return static_cast<int>(used_);
  }
  used_ = 1;
  // A peer that is not there (yet) answers our packets with refusals: no trouble of the socket.
  const bool transient =
      errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR || is_refusal(errno);
  return transient ? 0 : -1;
}

// Puts up to `most` behind those that are there. @return how many; -1 with errno
int DatagramReader::take(int fd, std::size_t most) {
  if (large_ && room_ < kLargest && used_ <= 1) give_room(kLargest);
  const int count = ::recvmmsg(fd, messages_.data() + used_, static_cast<unsigned>(most),
                               MSG_DONTWAIT | MSG_TRUNC, nullptr);
  for (int i = 0; i < count; ++i) note_size(used_++);
  if (count < 0 && is_refusal(errno)) ++refused_;
  return count;
}

// With MSG_TRUNC the kernel gives the size that the datagram had.
void DatagramReader::note_size(std::size_t index) {
  mmsghdr& message = messages_[index];
  senders_[index].address.size = message.msg_hdr.msg_namelen;
  if (message.msg_len <= kUsual) return;
  large_ = true;
  const std::size_t room = parts_[index].iov_len;
  if (message.msg_len <= room) return;
  cut_bytes_ += message.msg_len - room;
  message.msg_len = static_cast<unsigned>(room);
}

void DatagramReader::offer(std::size_t index) {
  msghdr& header = messages_[index].msg_hdr;
  header.msg_namelen = sizeof senders_[index].address.storage;
  header.msg_controllen = kControlBytes;
}

std::span<const std::uint8_t> DatagramReader::datagram(std::size_t index) const {
  return {static_cast<const std::uint8_t*>(parts_[index].iov_base), messages_[index].msg_len};
}

void DatagramReader::note_drops(const msghdr& header) {
  if (const auto drops = control_value<std::uint32_t>(header, SO_RXQ_OVFL)) kernel_drops_ = *drops;
}

// The first one has waited longest, but no longer than since the one before it came, or since the
// socket was seen empty: a wall clock that steps makes nothing old.
base::Duration DatagramReader::note_wait(base::RunTime now) {
  longest_ = std::max(now - empty_at_, base::Duration{});
  read_at_ = now.time_since_epoch() + wall_ahead_;
  const auto stamp = control_value<timespec>(messages_[0].msg_hdr, SCM_TIMESTAMPNS);
  const base::Duration apart = stamp ? read_at_ - as_duration(*stamp) : base::Duration{};
  const bool old = now - compared_at_ > kEstimateHolds;
  if (old || std::chrono::abs(apart) > kCloseStamp) compare_clocks();
  const base::Duration wait = wait_of(0);
  late_ = wait > kPrompt;
  ++arrivals_.packets;
  arrivals_.waited += std::min(wait, kMostArrival);
  return wait;
}

// Others may run between two looks at a clock; then once more.
void DatagramReader::compare_clocks() {
  constexpr base::Duration kAtOnce = std::chrono::microseconds(20);
  constexpr int kTries = 3;
  base::Duration took = base::Duration::max();
  for (int i = 0; i < kTries && took > kAtOnce; ++i) {
    const base::RunTime before = base::steady_now();
    timespec wall{};
    ::clock_gettime(CLOCK_REALTIME, &wall);
    compared_at_ = base::steady_now();
    took = compared_at_ - before;
    read_at_ = as_duration(wall);
    wall_ahead_ = read_at_ - (before + took / 2).time_since_epoch();
  }
}

base::Duration DatagramReader::wait_of(std::size_t index) const {
  const auto stamp = control_value<timespec>(messages_[index].msg_hdr, SCM_TIMESTAMPNS);
  if (!stamp) return {};
  return std::clamp(read_at_ - as_duration(*stamp), base::Duration{}, longest_);
}

int open_udp_socket(int family, const std::string& interface) {
  const int fd = ::socket(family, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (fd < 0) return -1;
  const int on = 1;
  ::setsockopt(fd, SOL_SOCKET, SO_RXQ_OVFL, &on, sizeof on);
  ::setsockopt(fd, SOL_SOCKET, SO_TIMESTAMPNS, &on, sizeof on);
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
