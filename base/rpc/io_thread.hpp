// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>
#include <functional>
#include <thread>
#include <utility>

namespace cas::base::rpc {

/// An io_context with a thread of its own. Declare it before the objects that use the context.
class IoThread {
 public:
  boost::asio::io_context& context() { return io_; }
  bool started() const { return thread_.joinable(); }

  /// @param prepare  runs first on the thread: its name and scheduling
  void start(std::function<void()> prepare) {
    thread_ = std::jthread([this, prepare = std::move(prepare)] {
      prepare();
      io_.run();
    });
  }
  /// Runs `close` on the thread and waits until no operation is pending. Only once started.
  void finish(std::function<void()> close) {
    boost::asio::post(io_, [this, close = std::move(close)] {
      close();
      work_.reset();
    });
    thread_.join();
  }

 private:
  boost::asio::io_context io_{1};
  boost::asio::executor_work_guard<boost::asio::io_context::executor_type> work_{
      io_.get_executor()};
  std::jthread thread_;
};

}  // namespace cas::base::rpc
