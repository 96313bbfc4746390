// SPDX-License-Identifier: BSD-3-Clause
#include "web/server/upstream.hpp"

#include <sys/un.h>

#include <boost/asio/buffer.hpp>
#include <boost/asio/read_until.hpp>
#include <boost/asio/write.hpp>
#include <chrono>
#include <nlohmann/json.hpp>
#include <utility>

namespace cas::web {
namespace {

namespace asio = boost::asio;
using base::rpc::Json;
using Error = boost::system::error_code;

constexpr std::size_t kMaxLine = 16U << 20;
constexpr std::size_t kMaxLines = 1024;  // lines that a program has not read yet
constexpr auto kRetryPause = std::chrono::milliseconds(250);
constexpr auto kCallTime = std::chrono::minutes(2);
constexpr auto kDeadlineLook = std::chrono::seconds(1);

}  // namespace

Upstream::Upstream(asio::io_context& io, std::string name, Find find, Handlers handlers)
    : io_(io),
      name_(std::move(name)),
      find_(std::move(find)),
      handlers_(std::move(handlers)),
      retry_(io),
      deadlines_(io) {}

void Upstream::close() {
  closed_ = true;
  retry_.cancel();
  deadlines_.cancel();
  Error ignored;
  if (socket_) socket_->close(ignored);
  fail_calls("casweb ends");
}

void Upstream::connect() {
  candidates_ = find_();
  found_.clear();
  trouble_.clear();
  try_next();
}

/// Tries one candidate after the other.
void Upstream::try_next() {
  while (!candidates_.empty()) {
    const std::filesystem::path path = candidates_.front();
    candidates_.erase(candidates_.begin());
    if (path.string().size() >= sizeof(sockaddr_un::sun_path)) {
      trouble_ = path.string() + ": the path is too long for a Unix socket";
      continue;
    }
    const auto socket = std::make_shared<Socket>(io_);
    socket->async_connect(
        path.string(), [self = shared_from_this(), socket, path](const Error& error) {
          if (self->closed_) return;
          if (!error) self->found_.push_back(socket);
          const bool nobody_there = error == boost::system::errc::no_such_file_or_directory ||
                                    error == boost::system::errc::connection_refused;
          if (error && !nobody_there) self->trouble_ = path.string() + ": " + error.message();
          self->try_next();
        });
    return;
  }
  on_tried();
}

void Upstream::on_tried() {
  if (found_.size() != 1) {
    if (found_.empty() && !trouble_.empty()) return lose(std::string(trouble_));
    return lose(found_.empty() ? "no " + name_ + " listens on this machine"
                               : "several " + name_ + "s listen: choose one by --" + name_);
  }
  socket_ = std::move(found_.front());
  found_.clear();
  rx_.clear();
  tx_.clear();
  up_ = true;
  reason_.clear();
  heard_ = base::steady_now();
  read_line();
  watch_deadlines();
  handlers_.on_up();
}

void Upstream::read_line() {
  asio::async_read_until(
      *socket_, asio::dynamic_buffer(rx_, kMaxLine), '\n',
      [self = shared_from_this(), socket = socket_](const Error& error, std::size_t size) {
        if (self->closed_ || self->socket_ != socket) return;
        if (error) return self->lose(self->name_ + " is gone");
        const std::string line = self->rx_.substr(0, size);
        self->rx_.erase(0, size);
        try {
          self->on_line(line);
        } catch (const Json::exception&) {
          return self->lose("what listens there is no " + self->name_);
        }
        if (self->socket_ == socket) self->read_line();
      });
}

void Upstream::on_line(const std::string& line) {
  heard_ = base::steady_now();
  const Json message = Json::parse(line, nullptr, false);
  if (!message.is_object()) return lose("what listens there is no " + name_);
  if (const auto method = message.find("method"); method != message.end()) {
    return handlers_.on_notification(method->get<std::string>(), message.value("params", Json()));
  }
  const auto id = message.find("id");
  if (id == message.end() || !id->is_number_unsigned()) return;
  const auto call = calls_.extract(id->get<std::uint64_t>());
  if (call.empty()) return;  // it came too late
  const base::rpc::Reply& reply = call.mapped().reply;
  const auto error = message.find("error");
  if (error == message.end()) return reply.result(message.value("result", Json()));
  reply.error(error->value("code", int{base::rpc::kInternalError}), error->value("message", ""),
              error->value("data", Json()));
}

void Upstream::call(const std::string& method, const Json& params, base::rpc::Reply reply) {
  if (!up_) return reply.error(base::rpc::kRefused, name_ + " is not there: " + reason_, nullptr);
  if (tx_.size() >= kMaxLines) {
    return reply.error(base::rpc::kRefused, name_ + " does not read", nullptr);
  }
  const std::uint64_t id = ++last_id_;
  Json request{{"jsonrpc", "2.0"}, {"id", id}, {"method", method}};
  if (!params.is_null()) request["params"] = params;
  calls_.emplace(id, Call{std::move(reply), base::steady_now() + kCallTime});
  tx_.push_back(request.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n");
  if (tx_.size() == 1) write();
}

void Upstream::write() {
  asio::async_write(*socket_, asio::buffer(tx_.front()),
                    [self = shared_from_this(), socket = socket_](const Error& error, std::size_t) {
                      if (self->closed_ || self->socket_ != socket) return;
                      if (error) return self->lose(self->name_ + " is gone");
                      self->tx_.pop_front();
                      if (!self->tx_.empty()) self->write();
                    });
}

void Upstream::lose(const std::string& reason) {
  const bool news = std::exchange(up_, false) || reason != reason_;
  reason_ = reason;
  if (const auto socket = std::exchange(socket_, nullptr)) {
    Error ignored;
    socket->close(ignored);
  }
  deadlines_.cancel();
  fail_calls(name_ + " is not there: " + reason);
  if (news) handlers_.on_down();
  retry();
}

void Upstream::retry() {
  retry_.expires_after(kRetryPause);
  retry_.async_wait([self = shared_from_this()](const Error& error) {
    if (!error && !self->closed_) self->connect();
  });
}

void Upstream::watch_deadlines() {
  deadlines_.expires_after(kDeadlineLook);
  deadlines_.async_wait([self = shared_from_this()](const Error& error) {
    if (error || self->closed_ || !self->up_) return;
    const base::RunTime now = base::steady_now();
    std::vector<base::rpc::Reply> late;
    std::erase_if(self->calls_, [&](const auto& entry) {
      if (now < entry.second.deadline) return false;
      late.push_back(entry.second.reply);
      return true;
    });
    for (const base::rpc::Reply& reply : late) {
      reply.error(base::rpc::kTimeout, self->name_ + " does not answer", nullptr);
    }
    self->watch_deadlines();
  });
}

void Upstream::fail_calls(const std::string& sentence) {
  for (const auto& [id, call] : std::exchange(calls_, {})) {
    call.reply.error(base::rpc::kRefused, sentence, nullptr);
  }
}

}  // namespace cas::web
