// SPDX-License-Identifier: BSD-3-Clause
#include "hils/run/loopback_udp.hpp"

#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <cstdint>
#include <future>
#include <span>
#include <utility>
#include <vector>

#include "hils/run/ticking_thread.hpp"

namespace cas::hils::test {
namespace {

constexpr std::array<std::uint8_t, 3> kBytes{1, 2, 3};
constexpr const char* kFailure = "no port";

std::vector<std::uint8_t> read(LoopbackUdp& socket) {
  const std::span<const std::uint8_t> bytes = socket.read();
  return {bytes.begin(), bytes.end()};
}

TEST(LoopbackUdp, AnswersThePeerThatWroteLast) {
  LoopbackUdp server(kFailure);
  server.send(kBytes);  // no peer is known: lost
  LoopbackUdp client(kFailure);
  ASSERT_TRUE(client.connect(server.port()));
  client.send(kBytes);
  EXPECT_EQ(read(server), std::vector<std::uint8_t>(kBytes.begin(), kBytes.end()));
  EXPECT_TRUE(read(server).empty());
  server.send(std::span(kBytes).first(1));
  EXPECT_EQ(read(client), std::vector<std::uint8_t>{1});
}

TEST(LoopbackUdp, OnceConnectedHearsNoOtherPort) {
  LoopbackUdp peer(kFailure);
  LoopbackUdp connected(kFailure);
  LoopbackUdp stranger(kFailure);
  ASSERT_TRUE(connected.connect(peer.port()));
  ASSERT_TRUE(stranger.connect(connected.port()));
  stranger.send(kBytes);
  EXPECT_TRUE(read(connected).empty());
}

TEST(TickingThread, WorksOnADatagramAndEndsWithTheObject) {
  LoopbackUdp socket(kFailure);
  std::promise<std::vector<std::uint8_t>> got;
  bool is_set = false;
  std::future<std::vector<std::uint8_t>> future = got.get_future();
  {
    // Within the period nothing but the datagram, and the end, wakes the thread.
    const TickingThread thread(socket.fd(), std::chrono::hours(1), [&] {
      std::vector<std::uint8_t> bytes = read(socket);
      if (bytes.empty() || is_set) return;
      is_set = true;
      got.set_value(std::move(bytes));
    });
    LoopbackUdp client(kFailure);
    ASSERT_TRUE(client.connect(socket.port()));
    client.send(kBytes);
    ASSERT_EQ(future.wait_for(std::chrono::seconds(10)), std::future_status::ready);
  }
  EXPECT_EQ(future.get().size(), kBytes.size());
}

TEST(TickingThread, WorksOnceInEachPeriod) {
  const LoopbackUdp silent(kFailure);
  std::promise<void> third;
  int ticks = 0;
  const TickingThread thread(silent.fd(), std::chrono::milliseconds(1), [&] {
    if (++ticks == 3) third.set_value();
  });
  EXPECT_EQ(third.get_future().wait_for(std::chrono::seconds(10)), std::future_status::ready);
}

}  // namespace
}  // namespace cas::hils::test
