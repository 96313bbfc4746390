// SPDX-License-Identifier: BSD-3-Clause
#include "base/rpc/client.hpp"

#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <deque>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>
#include <utility>

#include "base/error.hpp"
#include "base/os/descriptor.hpp"
#include "base/os/host_port.hpp"
#include "base/rpc/token.hpp"
#include "base/rpc/token_proof.hpp"

namespace cas::base::rpc {
namespace {

constexpr std::size_t kMaxLine = 64U << 20;        // a server gone mad must not fill the memory
constexpr std::size_t kMaxNotifications = 10'000;  // kept while a call waits; the oldest go first
constexpr std::string_view kUnixPrefix = "unix:";

[[noreturn]] void lost(const std::string& message) { throw ConnectionError(message, false); }

/// Waits until the descriptor is ready. @return false when the deadline came first
bool wait_for(int fd, short events, RunTime deadline) {
  while (true) {
    const Duration left = std::max(deadline - steady_now(), Duration::zero());
    const timespec timeout{static_cast<time_t>(left.count() / 1'000'000'000),
                           static_cast<long>(left.count() % 1'000'000'000)};
    pollfd entry{fd, events, 0};
    const int ready = ::ppoll(&entry, 1, &timeout, nullptr);
    if (ready > 0) return true;
    if (ready == 0) return false;
    if (errno != EINTR) lost(error_text(errno));
  }
}

}  // namespace

std::string address_fault(const std::string& address) {
  if (address.starts_with(kUnixPrefix)) return "";
  const std::optional<HostPort> parts = parse_host_port(address);
  if (!parts || !is_host_text(parts->host)) return "is neither HOST:PORT nor unix:PATH";
  const std::optional<std::uint16_t> port = parse_port(parts->port);
  return port && *port > 0 ? "" : "has no port from 1 to 65535";
}

struct Client::Impl {
  struct Notification {
    std::string method;
    Json params;
  };

  void connect(const std::string& to, RunTime deadline);
  void connect_unix(const std::string& path, RunTime deadline);
  void connect_tcp(const HostPort& target, RunTime deadline);
  bool try_connect(int family, const sockaddr* peer, socklen_t length, RunTime deadline);

  void send(std::string_view line, RunTime deadline);
  std::optional<Json> receive(RunTime deadline);
  std::optional<Json> parse_line(std::size_t newline);
  bool keep_notification(Json& message);

  std::string address;
  Descriptor fd;
  int connect_error = 0;
  std::string rx;
  std::size_t searched = 0;  // bytes of rx known to hold no newline
  std::uint64_t last_id = 0;
  std::deque<Notification> notifications;
};

bool Client::Impl::try_connect(int family, const sockaddr* peer, socklen_t length,
                               RunTime deadline) {
  fd = Descriptor(::socket(family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (!fd) lost(error_text(errno));
  if (::connect(fd.get(), peer, length) == 0) return true;
  connect_error = errno;
  if (connect_error != EINPROGRESS) return false;
  if (!wait_for(fd.get(), POLLOUT, deadline)) {
    throw ConnectionError(address + ": no connection in time", true);
  }
  socklen_t size = sizeof connect_error;
  ::getsockopt(fd.get(), SOL_SOCKET, SO_ERROR, &connect_error, &size);
  return connect_error == 0;
}

void Client::Impl::connect_unix(const std::string& path, RunTime deadline) {
  sockaddr_un peer{};
  peer.sun_family = AF_UNIX;
  if (path.empty() || path.size() >= sizeof peer.sun_path) {
    lost(address + ": a Unix socket's path has 1 to 107 characters");
  }
  std::memcpy(peer.sun_path, path.data(), path.size());
  if (!try_connect(AF_UNIX, reinterpret_cast<const sockaddr*>(&peer), sizeof peer, deadline)) {
    lost(address + ": " + error_text(connect_error));
  }
}

void Client::Impl::connect_tcp(const HostPort& target, RunTime deadline) {
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  const int error = ::getaddrinfo(target.host.c_str(), target.port.c_str(), &hints, &found);
  if (error != 0) lost(address + ": " + ::gai_strerror(error));
  const std::unique_ptr<addrinfo, decltype(&::freeaddrinfo)> owner(found, &::freeaddrinfo);
  for (const addrinfo* peer = found; peer != nullptr; peer = peer->ai_next) {
    if (!try_connect(peer->ai_family, peer->ai_addr, peer->ai_addrlen, deadline)) continue;
    const int on = 1;
    ::setsockopt(fd.get(), IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
    return;
  }
  lost(address + ": " + error_text(connect_error));
}

void Client::Impl::connect(const std::string& to, RunTime deadline) {
  if (const std::string fault = address_fault(to); !fault.empty()) lost("'" + to + "' " + fault);
  address = to;
  if (to.starts_with(kUnixPrefix)) {
    connect_unix(to.substr(kUnixPrefix.size()), deadline);
  } else {
    connect_tcp(*parse_host_port(to), deadline);
  }
}

void Client::Impl::send(std::string_view line, RunTime deadline) {
  if (!fd) lost(address + ": not connected");
  while (!line.empty()) {
    const ssize_t sent = ::send(fd.get(), line.data(), line.size(), MSG_NOSIGNAL);
    if (sent >= 0) {
      line.remove_prefix(static_cast<std::size_t>(sent));
    } else if (errno == EAGAIN) {
      if (wait_for(fd.get(), POLLOUT, deadline)) continue;
      fd.reset();  // half a line is out: nothing can follow it
      throw ConnectionError(address + ": the server does not read", true);
    } else if (errno != EINTR) {
      // The server may have said why before it closed: receive() finds out.
      return;
    }
  }
}

/// The next message, or nothing when none came in time.
std::optional<Json> Client::Impl::receive(RunTime deadline) {
  if (!fd) lost(address + ": not connected");
  std::array<char, 16384> chunk;
  while (true) {
    const std::size_t newline = rx.find('\n', searched);
    if (newline != std::string::npos) return parse_line(newline);
    searched = rx.size();
    const ssize_t size = ::recv(fd.get(), chunk.data(), chunk.size(), 0);
    if (size > 0) {
      rx.append(chunk.data(), static_cast<std::size_t>(size));
      if (rx.size() > kMaxLine) lost(address + ": the server sent an endless line");
    } else if (size == 0) {
      fd.reset();
      lost(address + ": the server closed the connection");
    } else if (errno == EAGAIN) {
      if (!wait_for(fd.get(), POLLIN, deadline)) return std::nullopt;
    } else if (errno != EINTR) {
      const int error = errno;
      fd.reset();
      lost(address + ": " + error_text(error));
    }
  }
}

std::optional<Json> Client::Impl::parse_line(std::size_t newline) {
  Json message =
      Json::parse(rx.begin(), rx.begin() + static_cast<std::ptrdiff_t>(newline), nullptr, false);
  rx.erase(0, newline + 1);
  searched = 0;
  if (message.is_object()) return message;
  fd.reset();
  lost(address + ": the server does not speak JSON-RPC");
}

/// Keeps a message for next_notification() when it is one.
bool Client::Impl::keep_notification(Json& message) {
  const auto method = message.find("method");
  if (method == message.end() || !method->is_string()) return false;
  if (notifications.size() == kMaxNotifications) notifications.pop_front();
  const auto params = message.find("params");
  notifications.push_back(
      {method->get<std::string>(), params == message.end() ? Json() : std::move(*params)});
  return true;
}

namespace {

[[noreturn]] void throw_call_error(const Json& error) {
  const Json data = error.is_object() ? error.value("data", Json()) : Json();
  const bool complete = error.is_object() && error.contains("code") &&
                        error["code"].is_number_integer() && error.contains("message") &&
                        error["message"].is_string();
  if (!complete) throw CallError(kInternalError, "an error without code or message", "null");
  throw CallError(error["code"].get<int>(), error["message"].get<std::string>(),
                  data.dump(-1, ' ', false, Json::error_handler_t::replace));
}

}  // namespace

Client::Client(const std::string& address, Duration connect_timeout)
    : impl_(std::make_unique<Impl>()) {
  impl_->connect(address, steady_now() + connect_timeout);
}
Client::~Client() = default;
Client::Client(Client&&) noexcept = default;
Client& Client::operator=(Client&&) noexcept = default;

bool Client::authorise_by_proof(const std::vector<std::string>& tokens) {
  ProofContext context;
  context.endpoint = server_endpoint(impl_->fd.get(), Prover::kClient);
  context.client_nonce = make_nonce();
  const Json hello = call("authorise", Json{{"nonce", context.client_nonce}});
  if (!hello.is_object() || !hello.contains("nonce") || !hello["nonce"].is_string() ||
      !hello.contains("proof") || !hello["proof"].is_string()) {
    return false;
  }
  context.server_nonce = hello["nonce"];
  const std::string proof = hello["proof"];
  const auto known = std::find_if(tokens.begin(), tokens.end(), [&](const std::string& token) {
    return same_token(token_proof(token, Prover::kServer, context), proof);
  });
  if (known == tokens.end()) return false;
  call("authorise", Json{{"proof", token_proof(*known, Prover::kClient, context)}});
  return true;
}

Json Client::call(const std::string& method, const Json& params, Duration timeout) {
  return call(method, params, timeout, {});
}

Json Client::call(const std::string& method, const Json& params, Duration silence,
                  const OnNotification& heard) {
  RunTime deadline = steady_now() + silence;
  const std::uint64_t id = ++impl_->last_id;
  Json request{{"jsonrpc", "2.0"}, {"id", id}, {"method", method}};
  if (!params.is_null()) request["params"] = params;
  impl_->send(request.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n", deadline);
  while (std::optional<Json> message = impl_->receive(deadline)) {
    if (impl_->keep_notification(*message)) {
      if (!heard) continue;
      const Impl::Notification news = std::move(impl_->notifications.back());
      impl_->notifications.pop_back();
      heard(news.method, news.params);
      deadline = steady_now() + silence;
      continue;
    }
    const Json answered = message->value("id", Json());
    const auto error = message->find("error");
    const bool failed = error != message->end();
    // An error without an id is about the connection as a whole.
    if (answered != id && !(failed && answered.is_null())) continue;  // of a call that timed out
    if (failed) throw_call_error(*error);
    const auto result = message->find("result");
    return result == message->end() ? Json() : std::move(*result);
  }
  throw ConnectionError(impl_->address + ": no answer to " + method + " in time", true);
}

bool Client::next_notification(std::string& method, Json& params, Duration timeout) {
  const RunTime deadline = steady_now() + timeout;
  while (impl_->notifications.empty()) {
    std::optional<Json> message = impl_->receive(deadline);
    if (!message) return false;
    impl_->keep_notification(*message);
  }
  method = std::move(impl_->notifications.front().method);
  params = std::move(impl_->notifications.front().params);
  impl_->notifications.pop_front();
  return true;
}

}  // namespace cas::base::rpc
