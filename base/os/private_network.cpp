// SPDX-License-Identifier: BSD-3-Clause
#include "base/os/private_network.hpp"

#include <fcntl.h>
#include <net/if.h>
#include <sched.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "base/os/descriptor.hpp"

namespace cas::base {
namespace {

std::string failure(const char* what) { return std::string(what) + ": " + std::strerror(errno); }

bool write_text(const char* file, const std::string& text) {
  const Descriptor out(::open(file, O_WRONLY | O_CLOEXEC));
  return out.get() >= 0 &&
         ::write(out.get(), text.data(), text.size()) == static_cast<ssize_t>(text.size());
}

/// The same user and group inside as outside.
bool map_user(uid_t user, gid_t group) {
  const std::string user_id = std::to_string(user);
  const std::string group_id = std::to_string(group);
  return write_text("/proc/self/setgroups", "deny") &&
         write_text("/proc/self/uid_map", user_id + " " + user_id + " 1") &&
         write_text("/proc/self/gid_map", group_id + " " + group_id + " 1");
}

bool raise_loopback() {
  const Descriptor socket(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  if (socket.get() < 0) return false;
  ifreq request{};
  std::strncpy(request.ifr_name, "lo", IFNAMSIZ - 1);
  if (::ioctl(socket.get(), SIOCGIFFLAGS, &request) != 0) return false;
  request.ifr_flags = static_cast<short>(request.ifr_flags | IFF_UP);
  return ::ioctl(socket.get(), SIOCSIFFLAGS, &request) == 0;
}

}  // namespace

std::optional<std::string> enter_private_network() {
  const uid_t user = ::geteuid();
  const gid_t group = ::getegid();
  if (::unshare(CLONE_NEWNET) != 0) {
    if (::unshare(CLONE_NEWUSER | CLONE_NEWNET) != 0) return failure("no network namespace");
    if (!map_user(user, group)) return failure("no user in the network namespace");
  }
  if (!raise_loopback()) return failure("no loopback in the network namespace");
  return std::nullopt;
}

}  // namespace cas::base
