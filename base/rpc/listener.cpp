// SPDX-License-Identifier: BSD-3-Clause
#include "base/rpc/listener.hpp"

#include <fcntl.h>
#include <grp.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/file.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <system_error>
#include <utility>

#include "base/error.hpp"
#include "base/os/log.hpp"
#include "base/rpc/address_in_use.hpp"
#include "base/rpc/local_port.hpp"
#include "base/time/clock.hpp"

namespace cas::base::rpc {
namespace {

constexpr int kAcceptsPerRound = 16;  // then other handlers get their turn
constexpr auto kRetryDelay = std::chrono::milliseconds(100);
constexpr auto kFolderPatience = std::chrono::seconds(2);

bool is_loopback(const sockaddr& address) {
  if (address.sa_family == AF_INET) {
    const auto& v4 = reinterpret_cast<const sockaddr_in&>(address);
    return (ntohl(v4.sin_addr.s_addr) >> 24) == IN_LOOPBACKNET;
  }
  if (address.sa_family == AF_INET6) {
    const auto& v6 = reinterpret_cast<const sockaddr_in6&>(address);
    return IN6_IS_ADDR_LOOPBACK(&v6.sin6_addr);
  }
  return false;
}

std::uint16_t bound_port(int fd) {
  sockaddr_storage address{};
  socklen_t length = sizeof address;
  ::getsockname(fd, reinterpret_cast<sockaddr*>(&address), &length);
  const bool v6 = address.ss_family == AF_INET6;
  return ntohs(v6 ? reinterpret_cast<const sockaddr_in6&>(address).sin6_port
                  : reinterpret_cast<const sockaddr_in&>(address).sin_port);
}

ListeningSocket listen_on(const addrinfo& found, const std::string& name) {
  Descriptor fd(::socket(found.ai_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (!fd) throw ConfigError(name + ": " + error_text(errno));
  const int on = 1;
  ::setsockopt(fd.get(), SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
  if (::bind(fd.get(), found.ai_addr, found.ai_addrlen) != 0 ||
      ::listen(fd.get(), SOMAXCONN) != 0) {
    const int error = errno;
    const std::string text = name + ": cannot listen: " + error_text(error);
    if (error == EADDRINUSE) throw AddressInUse(text);
    throw ConfigError(text);
  }
  ListeningSocket socket;
  socket.loopback = is_loopback(*found.ai_addr);
  socket.port = bound_port(fd.get());
  socket.fd = std::move(fd);
  return socket;
}

sockaddr_un unix_address(const std::filesystem::path& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  const std::string& text = path.native();
  if (text.empty() || text.size() >= sizeof address.sun_path) {
    throw ConfigError(text + ": a Unix socket's path has 1 to 107 characters");
  }
  std::memcpy(address.sun_path, text.data(), text.size());
  return address;
}

/// Whether a socket file has no listener. Tries to connect.
bool is_abandoned(const sockaddr_un& address) {
  const Descriptor probe(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  return probe &&
         ::connect(probe.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0 &&
         errno == ECONNREFUSED;
}

/// Removes a socket file of ours without a listener; refuses anything else in its place.
void remove_stale(const std::filesystem::path& path, const sockaddr_un& address) {
  struct stat status {};
  if (::lstat(path.c_str(), &status) != 0) return;
  if (!S_ISSOCK(status.st_mode)) throw ConfigError(path.string() + ": exists and is no socket");
  if (status.st_uid != ::geteuid()) {
    throw ConfigError(path.string() + ": is a socket of another user (uid " +
                      std::to_string(status.st_uid) + ")");
  }
  if (!is_abandoned(address)) {
    throw ConfigError(path.string() + ": is in use by another program");
  }
  ::unlink(path.c_str());
}

/// Locks a socket's folder from the check for a stale file until listen(): a socket that is bound
/// and does not listen yet looks stale. Gives up after kFolderPatience: in /tmp any user may lock
/// the folder.
class FolderLock {
 public:
  explicit FolderLock(const std::filesystem::path& folder)
      : fd_(::open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)) {
    if (!fd_) throw ConfigError(folder.string() + ": " + error_text(errno));
    const RunTime deadline = steady_now() + kFolderPatience;
    while (::flock(fd_.get(), LOCK_EX | LOCK_NB) != 0 && steady_now() < deadline) {
      if (errno != EWOULDBLOCK && errno != EINTR) return;  // a file system without locks
      ::poll(nullptr, 0, 10);
    }
  }

 private:
  Descriptor fd_;
};

/// The number of a group. @throws ConfigError
gid_t group_id(const std::filesystem::path& path, const std::string& group) {
  std::array<char, 16384> room;
  struct group entry {};
  struct group* found = nullptr;
  if (::getgrnam_r(group.c_str(), &entry, room.data(), room.size(), &found) != 0 ||
      found == nullptr) {
    throw ConfigError(path.string() + ": there is no group '" + group + "'");
  }
  return found->gr_gid;
}

constexpr gid_t kNoGroup = static_cast<gid_t>(-1);

/// Lets the members of a group in. Until then the file is its owner's alone.
void share_with(const std::filesystem::path& path, gid_t group) {
  struct stat status {};
  const bool known = ::lstat(path.c_str(), &status) == 0;
  if (!known ||
      (status.st_gid != group && ::lchown(path.c_str(), static_cast<uid_t>(-1), group) != 0)) {
    throw ConfigError(path.string() + ": cannot be given to its group: " + error_text(errno));
  }
  if (::chmod(path.c_str(), S_IRUSR | S_IWUSR | S_IRGRP | S_IWGRP) != 0) {
    throw ConfigError(path.string() + ": " + error_text(errno));
  }
}

/// Whether a client has closed its end, and sent nothing before.
bool has_left(int fd) {
  char first = 0;
  const ssize_t size = ::recv(fd, &first, 1, MSG_PEEK | MSG_DONTWAIT);
  return size == 0 || (size < 0 && errno != EAGAIN && errno != EINTR);
}

SocketFile socket_file(const std::filesystem::path& path) {
  struct stat status {};
  if (::lstat(path.c_str(), &status) != 0) return {};
  return {.device = status.st_dev, .inode = status.st_ino};
}

}  // namespace

ListeningSocket open_tcp(const std::string& address, std::uint16_t port) {
  const std::string name = address + ":" + std::to_string(port);
  addrinfo hints{};
  hints.ai_family = AF_UNSPEC;
  hints.ai_socktype = SOCK_STREAM;
  hints.ai_flags = AI_PASSIVE | AI_NUMERICSERV;
  addrinfo* found = nullptr;
  const int error = ::getaddrinfo(address.c_str(), std::to_string(port).c_str(), &hints, &found);
  if (error != 0) throw ConfigError(name + ": " + ::gai_strerror(error));
  const std::unique_ptr<addrinfo, decltype(&::freeaddrinfo)> owner(found, &::freeaddrinfo);
  return listen_on(*found, name);
}

ListeningSocket open_unix(const std::filesystem::path& path, const std::string& group) {
  const sockaddr_un address = unix_address(path);
  const gid_t shared = group.empty() ? kNoGroup : group_id(path, group);
  const FolderLock lock(path.parent_path());
  remove_stale(path, address);
  Descriptor fd(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  // The mode set before bind() is the file's from its first moment.
  if (!fd || ::fchmod(fd.get(), S_IRUSR | S_IWUSR) != 0 ||
      ::bind(fd.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
    throw ConfigError(path.string() + ": cannot listen: " + error_text(errno));
  }
  try {
    if (shared != kNoGroup) share_with(path, shared);
    if (::listen(fd.get(), SOMAXCONN) != 0) {
      throw ConfigError(path.string() + ": cannot listen: " + error_text(errno));
    }
  } catch (const ConfigError&) {
    ::unlink(path.c_str());
    throw;
  }
  ListeningSocket socket;
  socket.loopback = true;
  socket.path = path;
  socket.file = socket_file(path);
  socket.fd = std::move(fd);
  return socket;
}

void remove_stale_sockets(const std::filesystem::path& folder) {
  const FolderLock lock(folder);
  std::error_code end;
  for (std::filesystem::directory_iterator entry(folder, end), none; !end && entry != none;
       entry.increment(end)) {
    const std::filesystem::path& path = entry->path();
    struct stat status {};
    if (!is_command_socket_name(path.filename().native()) ||
        path.native().size() >= sizeof(sockaddr_un::sun_path) ||
        ::lstat(path.c_str(), &status) != 0 || !S_ISSOCK(status.st_mode) ||
        status.st_uid != ::geteuid()) {
      continue;
    }
    if (is_abandoned(unix_address(path))) ::unlink(path.c_str());
  }
}

Listener::Listener(boost::asio::io_context& io, ListeningSocket socket, OnClient on_client,
                   double max_accepts_s, std::function<Duration()> patience)
    : io_(io),
      descriptor_(io, socket.fd.release()),
      retry_(io),
      path_(std::move(socket.path)),
      file_(socket.file),
      on_client_(std::move(on_client)),
      patience_(std::move(patience)) {
  if (max_accepts_s > 0) rate_.emplace(max_accepts_s, steady_now());
}

void Listener::start() {
  if (!descriptor_.is_open()) return;
  boost::system::error_code ignored;
  retry_.cancel();
  descriptor_.cancel(ignored);
  do_wait();
}

void Listener::do_wait() {
  descriptor_.async_wait(boost::asio::posix::stream_descriptor::wait_read,
                         [self = shared_from_this()](const boost::system::error_code& error) {
                           if (error || !self->descriptor_.is_open()) return;
                           self->accept_waiting();
                         });
}

void Listener::accept_waiting() {
  const bool waited = std::exchange(waited_, false);  // clients that have waited get in
  for (int i = 0; i < kAcceptsPerRound && descriptor_.is_open(); ++i) {
    const Duration patience = patience_ && !waited ? patience_() : Duration::zero();
    if (patience > Duration::zero()) {
      waited_ = true;
      return accept_after(patience);
    }
    sockaddr_storage peer{};
    socklen_t length = sizeof peer;
    Descriptor fd(::accept4(descriptor_.native_handle(), reinterpret_cast<sockaddr*>(&peer),
                            &length, SOCK_CLOEXEC | SOCK_NONBLOCK));
    if (!fd) {
      if (errno == EMFILE || errno == ENFILE || errno == ENOBUFS || errno == ENOMEM) {
        return retry_later();
      }
      break;  // no client waits, or it left before accept
    }
    if (has_left(fd.get())) {
      waited_ = waited;
      continue;
    }
    const int on = 1;
    if (peer.ss_family != AF_UNIX) {
      ::setsockopt(fd.get(), IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
      ::setsockopt(fd.get(), SOL_SOCKET, SO_KEEPALIVE, &on, sizeof on);
    }
    StreamSocket socket(io_);
    boost::system::error_code error;
    socket.assign(boost::asio::generic::stream_protocol(peer.ss_family, 0), fd.get(), error);
    if (error) continue;
    fd.release();
    starved_ = false;
    on_client_(std::move(socket));
    if (!rate_ || !descriptor_.is_open()) continue;
    const Duration wait = rate_->take(steady_now());
    if (wait > Duration::zero()) return accept_after(wait);
  }
  if (descriptor_.is_open()) do_wait();
}

// No descriptors are left: waiting on the listening socket would spin.
void Listener::retry_later() {
  if (!std::exchange(starved_, true)) {
    log::warn("clients are kept waiting: " + error_text(errno));
  }
  accept_after(kRetryDelay);
}

void Listener::accept_after(Duration wait) {
  retry_.expires_after(wait);
  retry_.async_wait([self = shared_from_this()](const boost::system::error_code& error) {
    if (!error && self->descriptor_.is_open()) self->accept_waiting();
  });
}

void Listener::close() {
  boost::system::error_code ignored;
  retry_.cancel();
  descriptor_.close(ignored);
  on_client_ = nullptr;
  if (path_.empty()) return;
  const std::filesystem::path path = std::exchange(path_, {});
  const SocketFile there = socket_file(path);
  if (there.device == file_.device && there.inode == file_.inode) ::unlink(path.c_str());
}

}  // namespace cas::base::rpc
