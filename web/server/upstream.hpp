// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <boost/asio/steady_timer.hpp>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "base/rpc/message.hpp"
#include "base/time/clock.hpp"

namespace cas::web {

/// A program that casweb asks: its Unix socket, JSON-RPC lines, any number of calls under way.
/// Connects again whenever the connection is lost. Everything on the thread of `io`.
///
///   connect --> up --> read line --> answer of a call, or notification
///      ^---- pause <---- error: every call under way fails
class Upstream final : public std::enable_shared_from_this<Upstream> {
 public:
  /// Sockets that it may have. Of several on which a program listens none is taken.
  using Find = std::function<std::vector<std::filesystem::path>()>;
  struct Handlers {
    std::function<void()> on_up;
    std::function<void()> on_down;  ///< also when the reason why it is away changes
    std::function<void(const std::string& topic, const base::rpc::Json& params)> on_notification;
  };

  Upstream(boost::asio::io_context& io, std::string name, Find find, Handlers handlers);

  void start() { connect(); }
  void close();
  /// Answers `reply` in any case: with the program's answer, or -32000 while it is away, when it
  /// goes, and -32001 after two minutes.
  void call(const std::string& method, const base::rpc::Json& params, base::rpc::Reply reply);

  bool up() const { return up_; }
  /// Why it is not up, in one sentence.
  const std::string& reason() const { return reason_; }
  /// When it last said anything.
  base::RunTime heard() const { return heard_; }

 private:
  using Socket = boost::asio::local::stream_protocol::socket;
  struct Call {
    base::rpc::Reply reply;
    base::RunTime deadline;
  };

  void connect();
  void try_next();
  void on_tried();
  void read_line();
  void on_line(const std::string& line);
  void write();
  void lose(const std::string& reason);
  void retry();
  void watch_deadlines();
  void fail_calls(const std::string& sentence);

  boost::asio::io_context& io_;
  std::string name_;
  Find find_;
  Handlers handlers_;
  std::vector<std::filesystem::path> candidates_;  // still to be tried
  std::vector<std::shared_ptr<Socket>> found_;     // that took the connection
  std::string trouble_;                            // why one could not be tried
  std::shared_ptr<Socket> socket_;
  boost::asio::steady_timer retry_;
  boost::asio::steady_timer deadlines_;
  std::string rx_;
  std::deque<std::string> tx_;
  std::map<std::uint64_t, Call> calls_;
  std::uint64_t last_id_ = 0;
  bool up_ = false;
  bool closed_ = false;
  std::string reason_ = "casweb looks for it";
  base::RunTime heard_{};
};

}  // namespace cas::web
