// SPDX-License-Identifier: BSD-3-Clause
#include "base/os/notify.hpp"

#include <sys/socket.h>
#include <sys/un.h>

#include <cstddef>
#include <cstdlib>
#include <cstring>

#include "base/os/descriptor.hpp"
#include "base/os/mutex.hpp"

namespace cas::base {
namespace {

/// Address of NOTIFY_SOCKET: a path, or an abstract name written with '@' for its leading NUL.
/// @return the address's length, 0 when the text is neither
socklen_t parse_address(std::string_view text, sockaddr_un& address) {
  address = {};
  address.sun_family = AF_UNIX;
  const bool named = text.front() == '/' || text.front() == '@';
  if (!named || text.size() < 2 || text.size() >= sizeof address.sun_path) return 0;
  std::memcpy(address.sun_path, text.data(), text.size());
  std::size_t length = offsetof(sockaddr_un, sun_path) + text.size();
  if (text.front() == '@') {
    address.sun_path[0] = '\0';  // an abstract name is counted, not terminated
  } else {
    ++length;
  }
  return static_cast<socklen_t>(length);
}

}  // namespace

bool notify(std::string_view state) {
  const char* const variable = std::getenv("NOTIFY_SOCKET");
  if (variable == nullptr || *variable == '\0') return true;
  sockaddr_un address;
  const socklen_t length = parse_address(variable, address);
  if (length == 0) return false;
  // Kept open: a program that has run out of descriptors must still feed its watchdog.
  static Mutex mutex;
  static Descriptor fd CAS_GUARDED_BY(mutex);
  const MutexLock lock(mutex);
  if (!fd) fd = Descriptor(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  if (!fd) return false;
  const ssize_t sent = ::sendto(fd.get(), state.data(), state.size(), MSG_NOSIGNAL,
                                reinterpret_cast<const sockaddr*>(&address), length);
  return sent == static_cast<ssize_t>(state.size());
}

}  // namespace cas::base
