// SPDX-License-Identifier: BSD-3-Clause
#include "base/os/thread.hpp"

#include <gtest/gtest.h>
#include <pthread.h>
#include <sched.h>

#include <array>
#include <chrono>
#include <string>
#include <thread>
#include <vector>

namespace cas::base {
namespace {

TEST(ThreadOptions, AreReadFromAMap) {
  const ConfigNode node = ConfigNode::parse("fifo_priority: 20\ncpus: [0, 1]");
  const ThreadOptions options = parse_thread_options(node);
  EXPECT_EQ(options.fifo_priority, 20);
  EXPECT_EQ(options.cpus, (std::vector<int>{0, 1}));
  EXPECT_NO_THROW(node.reject_unused());
}

TEST(ThreadOptions, AnEmptyMapWishesNothing) {
  const ThreadOptions options = parse_thread_options(ConfigNode::empty());
  EXPECT_FALSE(options.fifo_priority);
  EXPECT_TRUE(options.cpus.empty());
}

TEST(ThreadOptions, ImpossibleValuesAreRefused) {
  for (const char* text : {"fifo_priority: 0", "fifo_priority: 100", "cpus: [-1]", "cpus: [99999]",
                           "cpus: 1", "fifo_priority: high"}) {
    EXPECT_THROW(parse_thread_options(ConfigNode::parse(text)), ConfigError) << text;
  }
}

TEST(ConfigureThisThread, NamesTheThreadWithFifteenCharacters) {
  std::thread([] {
    configure_this_thread("link_with_a_long_name", {});
    char name[32];
    ::pthread_getname_np(::pthread_self(), name, sizeof name);
    EXPECT_STREQ(name, "link_with_a_lon");
  }).join();
}

TEST(ConfigureThisThread, BindsTheThreadToACpuItMayUse) {
  std::thread([] {
    cpu_set_t allowed;
    ::pthread_getaffinity_np(::pthread_self(), sizeof allowed, &allowed);
    int cpu = 0;
    while (!CPU_ISSET(static_cast<std::size_t>(cpu), &allowed)) ++cpu;
    configure_this_thread("bound", {std::nullopt, {cpu}});
    cpu_set_t now;
    ::pthread_getaffinity_np(::pthread_self(), sizeof now, &now);
    EXPECT_EQ(CPU_COUNT(&now), 1);
    EXPECT_TRUE(CPU_ISSET(static_cast<std::size_t>(cpu), &now));
  }).join();
}

TEST(ConfigureThisThread, MissingRightsAreNoError) {
  std::string name;
  std::thread([&name] {
    configure_this_thread("fifo", {1, {CPU_SETSIZE - 1}});
    std::array<char, 16> text{};
    ::pthread_getname_np(::pthread_self(), text.data(), text.size());
    name = text.data();
  }).join();
  EXPECT_EQ(name, "fifo") << "the rest of the options is applied";
}

TEST(IdleThisThread, LowersTheCallingThreadAlone) {
  const int before = ::sched_getscheduler(0);
  int policy = -1;
  std::array<char, 16> name{};
  std::thread([&] {
    if (!lower_this_thread("quiet")) return;
    policy = ::sched_getscheduler(0);
    ::pthread_getname_np(::pthread_self(), name.data(), name.size());
  }).join();
  EXPECT_EQ(policy, SCHED_BATCH);
  EXPECT_STREQ(name.data(), "quiet");
  EXPECT_EQ(::sched_getscheduler(0), before);
}

TEST(ThreadTimes, GrowWithTheWorkOfTheThread) {
  const ThreadTimesReader reader;
  const auto before = reader.read();
  if (!before) GTEST_SKIP() << "this kernel counts no turns of threads";
  // Work until it shows: the kernel adds up at its ticks and when it changes threads.
  ThreadTimes after = *before;
  for (const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(10);
       std::chrono::steady_clock::now() < end;) {
    after = reader.read().value();
    if (after.ran > before->ran + std::chrono::milliseconds(10)) break;
  }
  EXPECT_GT(after.ran, before->ran + std::chrono::milliseconds(10));
  EXPECT_GE(after.turns, before->turns);
  EXPECT_GE(after.queued, before->queued);
}

TEST(ThreadTimes, BindsToOneCpuAndBack) {
  const std::vector<int> any = allowed_cpus();
  ASSERT_FALSE(any.empty());
  EXPECT_EQ(bind_to_cpus({any.back()}), 0);
  EXPECT_EQ(allowed_cpus(), std::vector<int>{any.back()});
  EXPECT_EQ(bind_to_cpus(any), 0);
  EXPECT_EQ(allowed_cpus(), any);
}

}  // namespace
}  // namespace cas::base
