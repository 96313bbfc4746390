// SPDX-License-Identifier: BSD-3-Clause
#include "base/rpc/server.hpp"

#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>
#include <vector>

#include "base/error.hpp"
#include "base/rpc/dispatcher.hpp"
#include "base/rpc/listener.hpp"
#include "base/rpc/session.hpp"
#include "base/rpc/token.hpp"

namespace cas::base::rpc {
namespace {

constexpr std::size_t kRefusedAtOnce = 16;  // clients over the limit that are still told why

}  // namespace

struct Server::Impl : std::enable_shared_from_this<Server::Impl> {
  Impl(boost::asio::io_context& context, const ServerLimits& bounds)
      : io(context), limits(bounds), dispatcher(std::make_shared<Dispatcher>()) {}

  void start_listener(ListeningSocket socket) {
    const bool needs_token = socket.path.empty();
    listeners.push_back(std::make_shared<Listener>(
        io, std::move(socket), [weak = weak_from_this(), needs_token](StreamSocket client) {
          if (const auto self = weak.lock()) self->on_client(std::move(client), needs_token);
        }));
    listeners.back()->start();
  }

  void on_client(StreamSocket client, bool needs_token) {
    if (sessions.size() >= limits.max_clients + kRefusedAtOnce) return;  // closes it
    const bool full = sessions.size() >= limits.max_clients;
    const auto session = std::make_shared<Session>(
        std::move(client), dispatcher, limits,
        [weak = weak_from_this()](const std::shared_ptr<Session>& closed) {
          if (const auto self = weak.lock()) self->sessions.erase(closed);
        });
    session->authorised = !(needs_token && dispatcher->has_token());
    sessions.insert(session);
    if (full) return session->refuse("the server has as many clients as it takes");
    session->start();
  }

  void close() {
    for (const auto& listener : std::exchange(listeners, {})) listener->close();
    for (const auto& session : std::exchange(sessions, {})) session->close();
  }

  boost::asio::io_context& io;
  ServerLimits limits;
  std::shared_ptr<Dispatcher> dispatcher;
  std::vector<std::shared_ptr<Listener>> listeners;
  std::set<std::shared_ptr<Session>> sessions;
};

Server::Server(boost::asio::io_context& io, ServerLimits limits)
    : impl_(std::make_shared<Impl>(io, limits)) {}

Server::~Server() { close(); }

void Server::add_method(const std::string& name, Method method) {
  impl_->dispatcher->add_method(name, std::move(method));
}

void Server::add_topic(const std::string& topic) { impl_->dispatcher->add_topic(topic); }

void Server::publish(const std::string& topic, const Json& params) {
  std::vector<std::shared_ptr<Session>> subscribers;
  for (const auto& session : impl_->sessions) {
    if (session->topics.contains(topic)) subscribers.push_back(session);
  }
  if (subscribers.empty()) return;
  const auto line =
      std::make_shared<const std::string>(Dispatcher::notification(topic, params) + "\n");
  for (const auto& session : subscribers) session->deliver_shared(line);
}

bool Server::has_subscribers(const std::string& topic) const {
  return std::any_of(impl_->sessions.begin(), impl_->sessions.end(),
                     [&](const auto& session) { return session->topics.contains(topic); });
}

void Server::require_token(const std::filesystem::path& file) {
  impl_->dispatcher->set_token(read_token(file));
}

std::uint16_t Server::listen_tcp(const std::string& address, std::uint16_t port) {
  ListeningSocket socket = open_tcp(address, port);
  if (!socket.loopback && !impl_->dispatcher->has_token()) {
    throw ConfigError(address + ": other hosts can reach this address; it needs a token");
  }
  const std::uint16_t bound = socket.port;
  impl_->start_listener(std::move(socket));
  return bound;
}

void Server::listen_unix(const std::filesystem::path& path) {
  impl_->start_listener(open_unix(path));
}

void Server::close() { impl_->close(); }

std::size_t Server::clients() const { return impl_->sessions.size(); }

}  // namespace cas::base::rpc
