// SPDX-License-Identifier: BSD-3-Clause
#include "base/rpc/server.hpp"

#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "base/error.hpp"
#include "base/os/lack_of_memory.hpp"
#include "base/rpc/client_places.hpp"
#include "base/rpc/dispatcher.hpp"
#include "base/rpc/listener.hpp"
#include "base/rpc/serve_budget.hpp"
#include "base/rpc/session.hpp"
#include "base/rpc/token.hpp"

namespace cas::base::rpc {
namespace {

constexpr std::size_t kRefusedAtOnce = 16;  // clients without a place that still get the reason

}  // namespace

struct Server::Impl : std::enable_shared_from_this<Server::Impl> {
  Impl(boost::asio::io_context& context, const ServerLimits& bounds)
      : io(context), limits(bounds), dispatcher(std::make_shared<Dispatcher>()) {}

  void start_listener(ListeningSocket socket) {
    if (!socket.path.empty()) listens_on_unix = true;
    auto on_accepted = [weak = weak_from_this()](StreamSocket client) {
      if (const auto self = weak.lock()) self->on_client(std::move(client));
    };
    listeners.push_back(std::make_shared<Listener>(
        io, std::move(socket), std::move(on_accepted), limits.max_accepts_s,
        [own = budget] { return own->before_next_client(steady_now()); }));
    listeners.back()->start();
  }

  void start() {
    for (const auto& listener : listeners) listener->start();
  }

  void on_client(StreamSocket client) {
    const auto session = std::make_shared<Session>(
        std::move(client), dispatcher, limits, budget,
        [weak = weak_from_this()](const std::shared_ptr<Session>& closed) {
          if (const auto self = weak.lock()) self->on_closed(closed);
        });
    session->authorised = needs_no_token(session->origin());
    const std::optional<std::string> fault = make_place(*session);
    if (fault && without_place() >= kRefusedAtOnce) {
      ++refusals[Refusal::kNoPlace];
      return;  // closes it
    }
    sessions.push_back(session);
    if (fault) return session->refuse(Refusal::kNoPlace, *fault);
    if (!outlive_lack_of_memory(session->name, [&] { session->start(); })) session->close();
  }

  bool needs_no_token(const ClientOrigin& client) const {
    return !dispatcher->has_token() || client.over_unix || (client.loopback && loopback_exempt);
  }

  void on_closed(const std::shared_ptr<Session>& session) {
    if (session->refusal != Refusal::kNone) ++refusals[session->refusal];
    std::erase(sessions, session);
  }

  /// Clients that are being turned away hold no place.
  /// @return why there is no place for a client; nullopt when there is one now
  std::optional<std::string> make_place(const Session& client) {
    std::vector<std::shared_ptr<Session>> held;
    std::vector<PlaceHolder> holders;
    for (const auto& session : sessions) {
      if (session->refusal == Refusal::kNoPlace) continue;
      held.push_back(session);
      holders.push_back({session->origin(), session->has_asked(), session->has_spoken()});
    }
    const PlaceDecision decision =
        find_place(client.origin(), holders, limits.max_clients, listens_on_unix);
    if (decision.displaced) displace(*held[*decision.displaced]);
    return decision.refusal;
  }

  void displace(Session& session) {
    if (without_place() < kRefusedAtOnce) {
      return session.refuse(Refusal::kNoPlace,
                            "another client needs the place; this one asked nothing");
    }
    session.refusal = Refusal::kNoPlace;
    session.close();
  }

  /// Clients that are being refused for lack of a place.
  std::size_t without_place() const {
    return static_cast<std::size_t>(
        std::count_if(sessions.begin(), sessions.end(),
                      [](const auto& session) { return session->refusal == Refusal::kNoPlace; }));
  }

  void close() {
    for (const auto& listener : std::exchange(listeners, {})) listener->close();
    for (const auto& session : std::exchange(sessions, {})) session->close();
  }

  boost::asio::io_context& io;
  ServerLimits limits;
  std::shared_ptr<Dispatcher> dispatcher;
  std::shared_ptr<ServeBudget> budget =
      std::make_shared<ServeBudget>(limits.max_cpu_share, steady_now());
  std::vector<std::shared_ptr<Listener>> listeners;
  bool listens_on_unix = false;
  std::vector<std::shared_ptr<Session>> sessions;  ///< in the order in which they came
  bool loopback_exempt = false;                    ///< from the token
  std::map<Refusal, std::uint64_t> refusals;
};

Server::Server(boost::asio::io_context& io, ServerLimits limits)
    : impl_(std::make_shared<Impl>(io, limits)) {}

Server::~Server() { close(); }

void Server::add_method(const std::string& name, Method method, double weight) {
  impl_->dispatcher->add_method(name, std::move(method), weight);
}

void Server::call(const std::string& name, const Json& params, const Reply& reply) {
  impl_->dispatcher->call(name, params, reply);
}

void Server::describe(Description description) {
  impl_->dispatcher->describe(std::move(description));
}

void Server::before_calls(std::function<void()> callback) {
  impl_->dispatcher->before_calls(std::move(callback));
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

void Server::require_token(const std::filesystem::path& file, bool loopback_exempt) {
  impl_->dispatcher->set_token(read_token(file));
  impl_->loopback_exempt = loopback_exempt;
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

void Server::listen_unix(const std::filesystem::path& path, const std::string& group) {
  impl_->start_listener(open_unix(path, group));
}

void Server::start() { impl_->start(); }

void Server::close() { impl_->close(); }

std::size_t Server::clients() const { return impl_->sessions.size() - impl_->without_place(); }

std::uint64_t Server::refused(Refusal why) const {
  const auto found = impl_->refusals.find(why);
  return found == impl_->refusals.end() ? 0 : found->second;
}

}  // namespace cas::base::rpc
