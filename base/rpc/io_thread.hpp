// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>
#include <chrono>
#include <functional>
#include <string_view>
#include <thread>
#include <utility>

#include "base/os/lack_of_memory.hpp"

namespace cas::base::rpc {

/// Runs the context until it is stopped or has no more to do. Lack of memory ends the handler that
/// met it, and what the handler would have waited for next.
/// @param io     has more work than the handler that may fail, for it ends with its last
/// @param who    whose work is lost, for the log
/// @param begin  starts all that is waited for, at first and after each loss: it takes back what
///               still waits
template <class Begin>
void run_context(boost::asio::io_context& io, std::string_view who, Begin&& begin) {
  constexpr auto kPause = std::chrono::milliseconds(10);
  const auto run = [&] {
    begin();
    io.run();
  };
  while (!outlive_lack_of_memory(who, run)) std::this_thread::sleep_for(kPause);
}

/// An io_context with a thread of its own. Declare it before the objects that use the context.
class IoThread {
 public:
  boost::asio::io_context& context() { return io_; }
  bool started() const { return thread_.joinable(); }

  /// @param prepare  runs first on the thread: its name and scheduling
  /// @param begin    as run_context() takes it
  void start(std::function<void()> prepare, std::function<void()> begin) {
    thread_ = std::jthread([this, prepare = std::move(prepare), begin = std::move(begin)] {
      outlive_lack_of_memory("thread of clients", prepare);
      run_context(io_, "thread of clients", begin);
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
