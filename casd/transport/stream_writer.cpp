// SPDX-License-Identifier: BSD-3-Clause
#include "casd/transport/stream_writer.hpp"

#include <sys/epoll.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/uio.h>
#include <termios.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <cstdint>
#include <utility>

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

ReaderWatch::ReaderWatch(int fd) : epoll_(::epoll_create1(EPOLL_CLOEXEC)) {
  epoll_event edges{};
  edges.events = EPOLLOUT | EPOLLET;
  ::epoll_ctl(epoll_.get(), EPOLL_CTL_ADD, fd, &edges);
  take_edge();
}

void ReaderWatch::watch(bool on) {
  on_ = on;
  if (!on) return;
  take_edge();
  in_doubt_ = false;
}

void ReaderWatch::wrote(base::Duration took) {
  take_edge();
  // Terminal and reader take longer to get the bytes, unless we had to wait.
  constexpr base::Duration kAtOnce = std::chrono::microseconds(30);
  in_doubt_ = in_doubt_ || took > kAtOnce;
}

bool ReaderWatch::has_read() {
  const bool read = take_edge();
  tells_ = tells_ || read;
  return take_doubt() || read;
}

bool ReaderWatch::take_edge() {
  epoll_event edge{};
  return ::epoll_wait(epoll_.get(), &edge, 1, 0) == 1;
}

StreamWriter::StreamWriter(base::Descriptor descriptor, Kind kind)
    : descriptor_(std::move(descriptor)), kind_(kind) {
  if (kind_ == Kind::kPseudoTerminal) reader_.emplace(descriptor_.get());
}

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
      break;
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
    break;
  }
  result.done = base::steady_now();
  return result;
}

WriteResult StreamWriter::write_rest(std::span<const std::uint8_t> bytes) {
  iovec part{const_cast<std::uint8_t*>(bytes.data()), bytes.size()};
  const std::ptrdiff_t gone = write_vector(&part, 1);
  return {.part_of_next = gone > 0 ? static_cast<std::size_t>(gone) : 0,
          .broken = gone < 0,
          .done = base::steady_now()};
}

std::size_t StreamWriter::unsent() const {
  return kind_ == Kind::kSerial ? unsent_bytes(descriptor_.get()) : 0;
}

bool StreamWriter::moved() {
  if (std::exchange(made_room_, false)) return true;
  if (reader_) {
    const bool read = reader_->has_read();
    return read || (!reader_->tells() && !full_);
  }
  return kind_ != Kind::kSerial || driver_moved();
}

void StreamWriter::watch(bool on) {
  if (reader_) return reader_->watch(on);
  if (!on || kind_ != Kind::kSerial) return;
  held_ = unsent_bytes(descriptor_.get());
  written_ = 0;
}

// Whether the driver has got rid of anything since the last look; one that always says the same
// has.
bool StreamWriter::driver_moved() {
  const std::size_t held = unsent_bytes(descriptor_.get());
  const bool moved = held == 0 || held < held_ + written_;
  held_ = held;
  written_ = 0;
  return moved;
}

// A zero begins no packet: every receiver skips it. Where it is in doubt, another one tells; a line
// that leaves nothing but doubt is believed to move.
void StreamWriter::nudge() {
  constexpr int kMost = 5;
  const std::uint8_t zero = 0;
  for (int i = 0; i < kMost; ++i) {
    if (reader_) reader_->take_doubt();
    write_rest({&zero, 1});
    if (!reader_ || !reader_->in_doubt()) return;
  }
}

bool StreamWriter::flush() {
  if (reader_ && !reader_->tells()) return false;
  ::tcflush(descriptor_.get(), TCOFLUSH);
  held_ = written_ = 0;
  full_ = made_room_ = false;
  nudge();
  return true;
}

// @return bytes gone, 0 when there is no room, -1 when the descriptor is of no more use
std::ptrdiff_t StreamWriter::write_vector(iovec* parts, std::size_t count) {
  std::ptrdiff_t gone = 0;
  const bool timed = reader_ && reader_->watches();
  const base::RunTime begin = timed ? base::steady_now() : base::RunTime{};
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
  if (gone >= 0) {
    std::size_t wanted = 0;
    for (std::size_t i = 0; i < count; ++i) wanted += parts[i].iov_len;
    made_room_ = made_room_ || (full_ && gone > 0);
    full_ = static_cast<std::size_t>(gone) < wanted;
    written_ += static_cast<std::size_t>(gone);
    if (timed) reader_->wrote(base::steady_now() - begin);
    return gone;
  }
  full_ = true;
  return is_transient(errno) ? 0 : -1;
}

}  // namespace cas::casd
