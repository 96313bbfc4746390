// SPDX-License-Identifier: BSD-3-Clause
#include "base/rpc/io_thread.hpp"

#include <gtest/gtest.h>

#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <new>
#include <stdexcept>

namespace cas::base::rpc::test {
namespace {

TEST(RunContext, BeginsAnewAfterAHandlerThatLackedMemory) {
  boost::asio::io_context io(1);
  const auto work = boost::asio::make_work_guard(io);
  boost::asio::steady_timer timer(io);
  int begun = 0;
  int rung = 0;
  run_context(io, "fixture", [&] {
    ++begun;
    timer.expires_after(std::chrono::milliseconds(1));
    timer.async_wait([&](const boost::system::error_code& error) {
      if (error) return;
      if (++rung < 3) throw std::bad_alloc();
      io.stop();
    });
  });
  EXPECT_EQ(rung, 3);
  EXPECT_EQ(begun, 3);
}

TEST(RunContext, OtherFaultsEndIt) {
  boost::asio::io_context io(1);
  const auto begin = [&io] { boost::asio::post(io, [] { throw std::runtime_error("a bug"); }); };
  EXPECT_THROW(run_context(io, "fixture", begin), std::runtime_error);
}

}  // namespace
}  // namespace cas::base::rpc::test
