// SPDX-License-Identifier: BSD-3-Clause
#include "casd/link/link_home.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <memory>
#include <thread>

#include "tests/support/wait_until.hpp"

namespace cas::casd::test {
namespace {

using cas::test::wait_until;

/// Receives `packets_a_turn` packets at each turn of its loop.
class FakeLink final : public Link {
 public:
  struct Figures {
    std::atomic<std::uint64_t> packets_a_turn{0};
    std::atomic<std::uint64_t> turns{0};
    std::atomic<std::thread::id> thread{};
    std::atomic<bool> closed{false};
  };
  explicit FakeLink(Figures& figures) : figures_(figures) {}
  ~FakeLink() override { figures_.closed = true; }
  void watch(PollSet& set, base::RunTime now) override {
    set.wake_by(now + std::chrono::milliseconds(1));
  }
  void serve(const PollSet&, base::RunTime) override {
    received_ += figures_.packets_a_turn;
    figures_.thread = std::this_thread::get_id();
    ++figures_.turns;
  }
  std::uint64_t received() const override { return received_; }
  std::shared_ptr<PacketPort> port() override { return nullptr; }

 private:
  Figures& figures_;
  std::uint64_t received_ = 0;
};

constexpr std::uint64_t kFlood = 100'000;  // packets a turn: a flood, however late the turns are

class LinkHomeTest : public testing::Test {
 protected:
  LinkHomeTest() { shared->start(); }
  ~LinkHomeTest() override {
    for (LinkHome* home : {&quiet_home, &busy_home}) home->stay();
    shared->stop();
    for (LinkHome* home : {&quiet_home, &busy_home}) home->stop();
  }
  static std::function<std::unique_ptr<LinkLoop>()> make(const std::string& name) {
    return [name] { return std::make_unique<LinkLoop>(name, base::ThreadOptions{}); };
  }
  void add_links() {
    auto link = std::make_unique<FakeLink>(busy);
    busy_link = link.get();
    busy_home.add(std::move(link));
    quiet_home.add(std::make_unique<FakeLink>(quiet));
    ASSERT_TRUE(wait_until([&] { return quiet.turns > 0 && busy.turns > 0; }));
  }
  bool apart() const { return quiet.thread.load() != busy.thread.load(); }

  FakeLink::Figures quiet;
  FakeLink::Figures busy;
  Link* busy_link = nullptr;
  std::shared_ptr<LinkLoop> shared = std::make_shared<LinkLoop>("links", base::ThreadOptions{});
  LinkHome quiet_home{shared, make("quiet")};
  LinkHome busy_home{shared, make("busy")};
};

TEST_F(LinkHomeTest, ALinkThatFloodsGetsAThreadAndSharesAgainWhenItIsCalm) {
  add_links();
  EXPECT_FALSE(apart());
  busy.packets_a_turn = kFlood;
  ASSERT_TRUE(wait_until([&] { return apart(); }));
  busy.packets_a_turn = 0;
  ASSERT_TRUE(wait_until([&] { return !apart(); }, std::chrono::seconds(30)));
  // And once more, with the thread that it had.
  busy.packets_a_turn = kFlood;
  ASSERT_TRUE(wait_until([&] { return apart(); }));
}

TEST_F(LinkHomeTest, ALinkIsClosedWhereverItIs) {
  add_links();
  busy.packets_a_turn = kFlood;
  ASSERT_TRUE(wait_until([&] { return apart(); }));
  busy_home.remove(busy_link);
  EXPECT_TRUE(busy.closed);
  const std::uint64_t turns = quiet.turns;
  EXPECT_TRUE(wait_until([&] { return quiet.turns > turns; })) << "the other one goes on";
  busy_home.wake();  // a call after the close does nothing
}

TEST_F(LinkHomeTest, ALinkThatFloodsAloneStays) {
  auto link = std::make_unique<FakeLink>(busy);
  busy.packets_a_turn = kFlood;
  busy_home.add(std::move(link));
  ASSERT_TRUE(wait_until([&] { return busy.turns > 100; }));
  int ran = 0;
  shared->run_on_loop([&] { ran = busy.thread.load() == std::this_thread::get_id() ? 1 : 2; });
  EXPECT_EQ(ran, 1);
}

TEST_F(LinkHomeTest, ALinkWithALoopOfItsOwnHasNowhereToGo) {
  LinkHome home(make("own")());
  std::unique_ptr<Link> link = std::make_unique<FakeLink>(busy);
  EXPECT_FALSE(home.take_calm(link));
  EXPECT_FALSE(home.take_flooding(link));
  EXPECT_TRUE(link);
}

TEST_F(LinkHomeTest, WhatStaysDoesNotMove) {
  add_links();
  busy_home.stay();
  busy.packets_a_turn = kFlood;
  const std::uint64_t turns = busy.turns;
  ASSERT_TRUE(wait_until([&] { return busy.turns > turns + 300; }));
  EXPECT_FALSE(apart());
}

TEST_F(LinkHomeTest, AFloodWithoutAThreadToBeHadStaysWithTheOthers) {
  LinkHome home(shared, []() -> std::unique_ptr<LinkLoop> { throw std::bad_alloc(); });
  FakeLink::Figures figures;
  auto link = std::make_unique<FakeLink>(figures);
  const Link* const at = link.get();
  home.add(std::move(link));
  quiet_home.add(std::make_unique<FakeLink>(quiet));
  figures.packets_a_turn = kFlood;
  ASSERT_TRUE(wait_until([&] { return figures.turns > 300 && quiet.turns > 0; }));
  EXPECT_EQ(figures.thread.load(), quiet.thread.load());
  home.remove(at);
  EXPECT_TRUE(figures.closed);
}

}  // namespace
}  // namespace cas::casd::test
