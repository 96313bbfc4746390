// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/mavlink_interface/udp_port.hpp"

#include <sched.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <ctime>
#include <nlohmann/json.hpp>

#include "base/os/command_port.hpp"

namespace cas::sim {
namespace {

constexpr int kSocketBufferBytes = 1 << 20;
/// More than the buffer holds: a sender that never pauses does not keep the step waiting.
constexpr int kMostBatches = 1024;
/// An answer is mostly there after 80 us. Looking that long costs less than the sleep and wake-up
/// of a processor in between: lockstep runs half as fast again.
constexpr base::Duration kSpin = std::chrono::microseconds(200);

std::int64_t nanoseconds(const timespec& t) {
  return static_cast<std::int64_t>(t.tv_sec) * 1'000'000'000 + t.tv_nsec;
}

/// Now on CLOCK_MONOTONIC minus now on CLOCK_REALTIME, in which the kernel stamps datagrams.
std::int64_t monotonic_minus_realtime() {
  timespec realtime{};
  clock_gettime(CLOCK_REALTIME, &realtime);
  return base::steady_now().time_since_epoch().count() - nanoseconds(realtime);
}

/// That this thread may run on: where there is one, the answer is made on it too.
int processors() {
  cpu_set_t set;
  return sched_getaffinity(0, sizeof set, &set) == 0 ? CPU_COUNT(&set) : 1;
}

void set_option(int socket, int name, int value) {
  setsockopt(socket, SOL_SOCKET, name, &value,
             sizeof value);  // each of them is an improvement only
}

}  // namespace

/// Room for the datagrams of one system call, with their sources and stamps.
struct UdpPort::Batch {
  static constexpr std::size_t kDatagrams = 16;
  static constexpr std::size_t kBytes = 4096;

  Batch() {
    for (std::size_t i = 0; i < kDatagrams; ++i) {
      vectors[i] = {bytes[i].data(), kBytes};
      headers[i].msg_hdr.msg_iov = &vectors[i];
      headers[i].msg_hdr.msg_iovlen = 1;
      headers[i].msg_hdr.msg_name = sources[i].data();
    }
  }
  /// The kernel overwrites lengths.
  void prepare() {
    for (std::size_t i = 0; i < kDatagrams; ++i) {
      headers[i].msg_hdr.msg_namelen = sizeof(sockaddr_storage);
      headers[i].msg_hdr.msg_control = control[i].data();
      headers[i].msg_hdr.msg_controllen = control[i].size();
    }
  }
  std::optional<std::int64_t> stamp_ns(std::size_t i) {
    for (cmsghdr* c = CMSG_FIRSTHDR(&headers[i].msg_hdr); c != nullptr;
         c = CMSG_NXTHDR(&headers[i].msg_hdr, c)) {
      if (c->cmsg_level != SOL_SOCKET || c->cmsg_type != SCM_TIMESTAMPNS) continue;
      timespec stamp{};
      std::memcpy(&stamp, CMSG_DATA(c), sizeof stamp);
      return nanoseconds(stamp);
    }
    return std::nullopt;
  }

  std::array<std::array<std::uint8_t, kBytes>, kDatagrams> bytes;
  std::array<iovec, kDatagrams> vectors;
  std::array<mmsghdr, kDatagrams> headers{};
  std::array<InetAddress, kDatagrams> sources;
  alignas(cmsghdr) std::array<std::array<char, 64>, kDatagrams> control;
};

UdpPort::UdpPort(const base::ConfigNode& local, const std::optional<base::ConfigNode>& remote)
    : batch_(std::make_unique<Batch>()) {
  const InetAddress address = InetAddress::parse(local);
  if (remote) peer_ = InetAddress::parse(*remote);
  if (peer_ && peer_->family() != address.family()) {
    remote->fail("is of another address family than local");
  }
  socket_ = socket(address.family(), SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  if (socket_ < 0) local.fail(std::string("no socket: ") + std::strerror(errno));
  set_option(socket_, SO_TIMESTAMPNS, 1);
  set_option(socket_, SO_RCVBUF, kSocketBufferBytes);
  set_option(socket_, SO_SNDBUF, kSocketBufferBytes);
  if (bind(socket_, address.data(), address.size()) != 0) {
    const int error = errno;
    close(socket_);
    const auto fail = [&] { local.fail(std::string("cannot be bound: ") + std::strerror(error)); };
    if (error != EADDRINUSE) fail();
    base::bind_command_port(fail);
  }
}

UdpPort::~UdpPort() { close(socket_); }

bool UdpPort::send(std::span<const std::uint8_t> packet) {
  if (!peer_) {
    ++without_peer_;
    return false;
  }
  const ssize_t sent = sendto(socket_, packet.data(), packet.size(), MSG_DONTWAIT | MSG_NOSIGNAL,
                              peer_->data(), peer_->size());
  if (sent == static_cast<ssize_t>(packet.size())) {
    ++sent_datagrams_;
    return true;
  }
  ++(errno == EAGAIN || errno == ENOBUFS ? queue_full_ : send_errors_);
  return false;
}

void UdpPort::poll(const OnBytes& on_bytes) {
  for (int batch = 0; batch < kMostBatches; ++batch) {
    if (read_batch(on_bytes) < static_cast<int>(Batch::kDatagrams)) return;
  }
}

int UdpPort::read_batch(const OnBytes& on_bytes) {
  Batch& batch = *batch_;
  batch.prepare();
  const int count =
      recvmmsg(socket_, batch.headers.data(), Batch::kDatagrams, MSG_DONTWAIT, nullptr);
  if (count <= 0) return 0;
  const std::int64_t to_monotonic = monotonic_minus_realtime();
  const base::RunTime read_at = base::steady_now();
  for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
    const msghdr& header = batch.headers[i].msg_hdr;
    batch.sources[i].set_size(header.msg_namelen);
    if (!is_from_peer(batch.sources[i])) {
      ++foreign_;
      continue;
    }
    ++received_datagrams_;
    if ((header.msg_flags & MSG_TRUNC) != 0) ++cut_;
    const auto stamp = batch.stamp_ns(i);
    const base::RunTime at =
        stamp ? std::min(base::RunTime(base::Duration(*stamp + to_monotonic)), read_at) : read_at;
    on_bytes({batch.bytes[i].data(), batch.headers[i].msg_len}, at);
  }
  return count;
}

bool UdpPort::is_from_peer(const InetAddress& source) {
  if (!peer_) peer_ = source;
  return source == *peer_;
}

bool UdpPort::wait(base::Duration timeout) {
  static const bool spins = processors() > 1;
  if (spins) {
    const base::RunTime until = base::steady_now() + std::min(timeout, kSpin);
    do {
      if (has_datagram()) return true;
      sched_yield();  // a thread that is to bring the answer may wait for this processor
    } while (base::steady_now() < until);
  }
  return wait_readable(socket_, -1, timeout);
}

/// Also when the next read would fail: it clears the error.
bool UdpPort::has_datagram() const {
  return recv(socket_, nullptr, 0, MSG_PEEK | MSG_DONTWAIT) >= 0 || errno != EAGAIN;
}

std::string UdpPort::endpoint() const { return "udp " + bound_address(socket_); }

void UdpPort::add_figures(nlohmann::ordered_json& figures) const {
  figures["sent_datagrams"] = sent_datagrams_;
  figures["received_datagrams"] = received_datagrams_;
  figures["queue_full"] = queue_full_;
  figures["send_errors"] = send_errors_;
  figures["without_peer"] = without_peer_;
  figures["foreign_datagrams"] = foreign_;
  figures["cut_datagrams"] = cut_;
}

}  // namespace cas::sim
