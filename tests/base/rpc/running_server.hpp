// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>
#include <chrono>
#include <functional>
#include <future>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "base/rpc/server.hpp"
#include "base/time/clock.hpp"

namespace cas::base::rpc {

inline constexpr Duration kPatience = std::chrono::seconds(20);  // for events that must happen

/// A server on its own thread with a few methods, on a free TCP port.
///   echo    answers with its parameters       fail    answers with an error
///   keep    answers when answer_kept() says    throw   throws
///   drop    forgets its reply                  big     answers with 100 kB
class RunningServer {
 public:
  explicit RunningServer(ServerLimits limits = {}) : server_(std::in_place, io_, limits) {
    add_methods();
    server_->add_topic("status");
    port_ = server_->listen_tcp("127.0.0.1", 0);
    thread_ = std::thread([this] { io_.run(); });
  }
  ~RunningServer() {
    run([this] { server_.reset(); });
    work_.reset();
    thread_.join();
  }
  RunningServer(const RunningServer&) = delete;
  RunningServer& operator=(const RunningServer&) = delete;

  std::uint16_t port() const { return port_; }
  std::string address() const { return "127.0.0.1:" + std::to_string(port_); }

  /// Runs `work` on the server's thread and waits for its end.
  template <class Work>
  auto run(Work work) -> decltype(work()) {
    std::packaged_task<decltype(work())()> task(std::move(work));
    auto done = task.get_future();
    boost::asio::post(io_, [&task] { task(); });
    return done.get();
  }
  /// Asks on the server's thread until `condition` holds or patience ends.
  bool wait_until(const std::function<bool(Server&)>& condition) {
    const RunTime deadline = steady_now() + kPatience;
    while (!run([&] { return condition(*server_); })) {
      if (steady_now() > deadline) return false;
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return true;
  }
  bool wait_for_clients(std::size_t count) {
    return wait_until([count](Server& server) { return server.clients() == count; });
  }
  bool wait_for_refused(Refusal why, std::uint64_t count) {
    return wait_until([why, count](Server& server) { return server.refused(why) == count; });
  }
  /// How many calls of `keep` wait for answer_kept().
  std::size_t kept() {
    return run([this] { return kept_.size(); });
  }
  bool wait_for_kept(std::size_t count) {
    return wait_until([this, count](Server&) { return kept_.size() == count; });
  }
  void publish(const std::string& topic, const Json& params) {
    run([&] { server_->publish(topic, params); });
  }
  /// Answers the kept calls with true, newest first.
  void answer_kept() {
    run([this] {
      while (!kept_.empty()) {
        const Reply reply = std::move(kept_.back());
        kept_.pop_back();
        reply.result(true);
      }
    });
  }
  Server& server() { return *server_; }

 private:
  void add_methods() {
    server_->add_method("echo", [](const Json& params, Reply reply) { reply.result(params); });
    server_->add_method("fail", [](const Json&, Reply reply) {
      reply.error(kRefused, "refused", Json{{"result", 4}});
    });
    server_->add_method("keep",
                        [this](const Json&, Reply reply) { kept_.push_back(std::move(reply)); });
    server_->add_method("drop", [](const Json&, Reply) {});
    server_->add_method("big",
                        [](const Json&, Reply reply) { reply.result(std::string(100'000, 'x')); });
    server_->add_method("throw", [](const Json&, Reply) { throw std::runtime_error("a bug"); });
    server_->add_method("close", [this](const Json&, Reply reply) {
      server_->close();
      reply.result(true);
    });
  }

  boost::asio::io_context io_;
  boost::asio::executor_work_guard<boost::asio::io_context::executor_type> work_{
      io_.get_executor()};
  std::vector<Reply> kept_;
  std::optional<Server> server_;
  std::uint16_t port_ = 0;
  std::thread thread_;
};

}  // namespace cas::base::rpc
