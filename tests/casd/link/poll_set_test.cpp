// SPDX-License-Identifier: BSD-3-Clause
#include "casd/link/poll_set.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <array>

namespace cas::casd::test {
namespace {

constexpr timespec kAtOnce{0, 0};

class Pipe {
 public:
  Pipe() {
    std::array<int, 2> ends{};
    EXPECT_EQ(::pipe2(ends.data(), O_CLOEXEC | O_NONBLOCK), 0);
    read_end = base::Descriptor(ends[0]);
    write_end_ = base::Descriptor(ends[1]);
    opened = OpenDescriptor(read_end.get());
  }
  void fill() { EXPECT_EQ(::write(write_end_.get(), "x", 1), 1); }
  /// The reading end gets this number, which is free.
  void open_as(int number) {
    if (read_end.get() == number) return;
    EXPECT_EQ(::dup3(read_end.get(), number, O_CLOEXEC), number);
    read_end = base::Descriptor(number);
    opened = OpenDescriptor(number);
  }

  base::Descriptor read_end;
  OpenDescriptor opened;

 private:
  base::Descriptor write_end_;
};

TEST(PollSet, TellsWhichDescriptorHasSomething) {
  Pipe empty;
  Pipe full;
  full.fill();
  PollSet set;
  const std::size_t first = set.add(empty.opened, POLLIN);
  const std::size_t second = set.add(full.opened, POLLIN);
  ASSERT_EQ(set.wait({}), 0);
  EXPECT_EQ(set.revents(first), 0);
  EXPECT_EQ(set.revents(second), POLLIN);
}

TEST(PollSet, WaitsNoLongerThanItsLimitAndThenHasNoEvents) {
  Pipe pipe;
  pipe.fill();
  PollSet set;
  const std::size_t entry = set.add(pipe.opened, POLLIN);
  ASSERT_EQ(set.wait({}), 0);
  char byte = 0;
  ASSERT_EQ(::read(pipe.read_end.get(), &byte, 1), 1);
  ASSERT_EQ(set.wait(timespec{0, 1'000'000}), 0);
  EXPECT_EQ(set.revents(entry), 0);
}

TEST(PollSet, WatchesAnotherDescriptorOfTheSameNumber) {
  auto old = std::make_unique<Pipe>();
  PollSet set;
  const auto turn = [&set](const OpenDescriptor& fd) {
    set.clear();
    const std::size_t entry = set.add(fd, POLLIN);
    EXPECT_EQ(set.wait(kAtOnce), 0);
    return set.revents(entry);
  };
  EXPECT_EQ(turn(old->opened), 0);
  const int number = old->read_end.get();
  old.reset();
  Pipe fresh;
  fresh.open_as(number);
  fresh.fill();
  EXPECT_EQ(turn(fresh.opened), POLLIN);
}

TEST(PollSet, KeepsANumberApartThatAnotherEntryHadBefore) {
  auto first = std::make_unique<Pipe>();
  Pipe second;
  PollSet set;
  set.add(first->opened, POLLIN);
  set.add(second.opened, POLLIN);
  ASSERT_EQ(set.wait(kAtOnce), 0);
  const int number = first->read_end.get();
  first.reset();
  second.open_as(number);
  second.fill();
  set.clear();
  const std::size_t none = set.add({}, POLLIN);
  const std::size_t moved = set.add(second.opened, POLLIN);
  ASSERT_EQ(set.wait({}), 0);
  EXPECT_EQ(set.revents(none), 0);
  EXPECT_EQ(set.revents(moved), POLLIN);
}

TEST(PollSet, ForgetsWhatATurnDoesNotName) {
  Pipe full;
  full.fill();
  Pipe other;
  PollSet set;
  set.add(other.opened, POLLIN);
  set.add(full.opened, POLLIN);
  ASSERT_EQ(set.wait(kAtOnce), 0);
  set.clear();
  const std::size_t entry = set.add(other.opened, POLLIN);
  ASSERT_EQ(set.wait(kAtOnce), 0);
  EXPECT_EQ(set.revents(entry), 0);
  set.clear();
  set.add(other.opened, POLLIN);
  const std::size_t again = set.add(full.opened, POLLIN);
  ASSERT_EQ(set.wait(kAtOnce), 0);
  EXPECT_EQ(set.revents(again), POLLIN);
}

TEST(PollSet, WatchesAgainWhatItHasReleased) {
  Pipe full;
  full.fill();
  PollSet set;
  set.add(full.opened, POLLIN);
  ASSERT_EQ(set.wait({}), 0);
  set.release();
  const std::size_t entry = set.add(full.opened, POLLIN);
  ASSERT_EQ(set.wait({}), 0);
  EXPECT_EQ(set.revents(entry), POLLIN);
}

TEST(PollSet, TellsRoomOnlyToWhoAsksForIt) {
  std::array<int, 2> ends{};
  ASSERT_EQ(::pipe2(ends.data(), O_CLOEXEC | O_NONBLOCK), 0);
  const base::Descriptor read_end(ends[0]);
  const base::Descriptor write_end(ends[1]);
  const OpenDescriptor opened(write_end.get());
  PollSet set;
  for (const short events : {short{0}, short{POLLOUT}, short{0}}) {
    set.clear();
    const std::size_t entry = set.add(opened, events);
    ASSERT_EQ(set.wait(kAtOnce), 0);
    EXPECT_EQ(set.revents(entry), events);
  }
}

TEST(PollSet, TellsOfADescriptorThatIsNotOpenAndOfTheOthers) {
  constexpr int kNotOpen = 1'000'000;
  Pipe pipe;
  pipe.fill();
  PollSet set;
  const std::size_t bad = set.add(OpenDescriptor(kNotOpen), POLLIN);
  const std::size_t good = set.add(pipe.opened, POLLIN);
  for (int i = 0; i < 2; ++i) {  // as long as it is named
    EXPECT_EQ(set.wait({}), EBADF);
    EXPECT_EQ(set.revents(bad), POLLERR);
    EXPECT_EQ(set.revents(good), POLLIN);
  }
  set.clear();
  set.add({}, POLLIN);
  set.add(pipe.opened, POLLIN);
  EXPECT_EQ(set.wait({}), 0);
  EXPECT_EQ(set.revents(bad), 0);
  EXPECT_EQ(set.revents(good), POLLIN);
}

}  // namespace
}  // namespace cas::casd::test
