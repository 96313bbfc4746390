// SPDX-License-Identifier: BSD-3-Clause
#include "hils/firmware/pty_cable.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <numeric>
#include <string>
#include <utility>

#include "hils/run/run_paths.hpp"
#include "tests/support/wait_until.hpp"

namespace cas::hils {
namespace {

/// Bytes whose order can be seen.
std::string numbered(std::size_t size) {
  std::string bytes(size, '\0');
  std::iota(bytes.begin(), bytes.end(), char{0});
  return bytes;
}

/// An open serial port.
class Port {
 public:
  explicit Port(const std::filesystem::path& link)
      : fd_(::open(link.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC)) {}
  ~Port() { ::close(fd_); }
  Port(const Port&) = delete;
  Port& operator=(const Port&) = delete;
  int get() const { return fd_; }

 private:
  int fd_;
};

/// A program at each end of the cable.
class PtyCableTest : public testing::Test {
 protected:
  /// Writes as the port takes it. @return whether everything went
  static bool write_all(const Port& port, const std::string& bytes) {
    std::size_t written = 0;
    return cas::test::wait_until([&] {
      const ssize_t size = ::write(port.get(), bytes.data() + written, bytes.size() - written);
      if (size > 0) written += static_cast<std::size_t>(size);
      return written == bytes.size();
    });
  }

  /// Reads all waiting bytes.
  static void read_into(std::string& all, const Port& port) {
    char chunk[4096];
    ssize_t size = 0;
    while ((size = ::read(port.get(), chunk, sizeof(chunk))) > 0) {
      all.append(chunk, static_cast<std::size_t>(size));
    }
  }

  RunDirectory folder_;
  PtyCable relay_{folder_.path() / "first", folder_.path() / "second"};
  Port first_{folder_.path() / "first"};
  Port second_{folder_.path() / "second"};
};

TEST_F(PtyCableTest, CarriesBothWays) {
  ASSERT_TRUE(write_all(first_, "there"));
  ASSERT_TRUE(write_all(second_, "back"));
  std::string at_first;
  std::string at_second;
  EXPECT_TRUE(cas::test::wait_until([&] {
    read_into(at_first, first_);
    read_into(at_second, second_);
    return at_first == "back" && at_second == "there";
  })) << at_first
      << at_second;
}

TEST_F(PtyCableTest, UnpluggedAtItsFirstEndComesBackUnderTheSameName) {
  const auto link = folder_.path() / "first";
  relay_.set_plugged(false);
  ASSERT_TRUE(cas::test::wait_until([&] { return !std::filesystem::exists(link); }));
  char byte = 0;
  EXPECT_TRUE(cas::test::wait_until([&] {
    const ssize_t size = ::read(first_.get(), &byte, 1);
    return size == 0 || (size < 0 && errno == EIO);
  })) << "the port is gone";
  ASSERT_TRUE(write_all(second_, "lost"));
  relay_.set_plugged(true);
  ASSERT_TRUE(cas::test::wait_until([&] { return std::filesystem::exists(link); }));
  const Port again(link);
  std::string got;
  EXPECT_TRUE(cas::test::wait_until([&] {
    (void)!::write(second_.get(), "b", 1);
    read_into(got, again);
    return !got.empty();
  }));
  EXPECT_EQ(got.find("lost"), std::string::npos);
  EXPECT_EQ(relay_.lost_bytes(), 0U) << "they were not lost for want of a reader";
}

TEST_F(PtyCableTest, DoesToBothDirectionsWhatItsLineDoes) {
  relay_.set_line(fcu::LineConfig{.packet_duplicate = 1});
  for (const auto& [from, to] : {std::pair(&first_, &second_), std::pair(&second_, &first_)}) {
    std::string got;
    EXPECT_TRUE(
        cas::test::wait_until([&] {  // the first one may be carried before the order is taken
          got.clear();
          return write_all(*from, "packet") && cas::test::wait_until([&] {
                   read_into(got, *to);
                   return got.size() >= 6;
                 }) &&
                 got.starts_with("packetpacket");
        }))
        << got;
  }
}

TEST_F(PtyCableTest, KeepsWhatAPortThatIsReadLateHasNoRoomFor) {
  // More than a terminal holds (19 to 68 kB, as the kernel counts it), less than it and the cable.
  const std::string sent = numbered(75'000);
  ASSERT_TRUE(write_all(first_, sent));
  std::string got;
  EXPECT_TRUE(cas::test::wait_until([&] {
    read_into(got, second_);
    return got.size() == sent.size();
  })) << got.size();
  EXPECT_TRUE(got == sent);
  EXPECT_EQ(relay_.lost_bytes(), 0U);
}

TEST_F(PtyCableTest, CountsWhatAPortThatNobodyReadsLoses) {
  const std::string sent = numbered(1'000'000);
  ASSERT_TRUE(write_all(first_, sent));
  ASSERT_TRUE(cas::test::wait_until([&] { return relay_.lost_bytes() > 0; }));
  std::string got;
  EXPECT_TRUE(cas::test::wait_until([&] {
    read_into(got, second_);
    return got.size() + relay_.lost_bytes() == sent.size();
  })) << got.size()
      << " + " << relay_.lost_bytes();
}

}  // namespace
}  // namespace cas::hils
