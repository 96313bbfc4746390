// SPDX-License-Identifier: BSD-3-Clause
#include "base/os/notify.hpp"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstddef>
#include <cstring>

#include "tests/base/config/scoped_environment.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::base {
namespace {

/// A datagram socket as a service manager listens on; '@' means the NUL of an abstract name.
class NotifySocket {
 public:
  explicit NotifySocket(const std::string& name) : fd_(::socket(AF_UNIX, SOCK_DGRAM, 0)) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::memcpy(address.sun_path, name.data(), name.size());
    if (name.front() == '@') address.sun_path[0] = '\0';
    const std::size_t length =
        offsetof(sockaddr_un, sun_path) + name.size() + (name.front() == '@' ? 0 : 1);
    EXPECT_EQ(
        ::bind(fd_, reinterpret_cast<const sockaddr*>(&address), static_cast<socklen_t>(length)),
        0);
  }
  ~NotifySocket() { ::close(fd_); }
  NotifySocket(const NotifySocket&) = delete;
  NotifySocket& operator=(const NotifySocket&) = delete;

  std::string receive() const {
    char buffer[256];
    const ssize_t size = ::recv(fd_, buffer, sizeof buffer, MSG_DONTWAIT);
    return size < 0 ? "" : std::string(buffer, static_cast<std::size_t>(size));
  }

 private:
  int fd_;
};

TEST(Notify, WithoutAServiceManagerDoesNothing) {
  const ScopedEnvironment variable("NOTIFY_SOCKET", nullptr);
  EXPECT_TRUE(notify("READY=1"));
}

TEST(Notify, SendsTheStateToAPath) {
  const cas::test::TemporaryFolder folder;
  const std::string path = (folder.path() / "notify").string();
  const NotifySocket manager(path);
  const ScopedEnvironment variable("NOTIFY_SOCKET", path.c_str());
  EXPECT_TRUE(notify("READY=1\nSTATUS=udp 14560"));
  EXPECT_EQ(manager.receive(), "READY=1\nSTATUS=udp 14560");
}

TEST(Notify, SendsTheStateToAnAbstractName) {
  const std::string name = "@cas_notify_test_" + std::to_string(::getpid());
  const NotifySocket manager(name);
  const ScopedEnvironment variable("NOTIFY_SOCKET", name.c_str());
  EXPECT_TRUE(notify("STOPPING=1"));
  EXPECT_EQ(manager.receive(), "STOPPING=1");
}

TEST(Notify, FailsWhenNobodyListens) {
  const ScopedEnvironment variable("NOTIFY_SOCKET", "/nowhere/notify");
  EXPECT_FALSE(notify("READY=1"));
}

TEST(Notify, FailsForAnAddressOfAnotherKind) {
  for (const std::string& address :
       {std::string("relative/path"), std::string("/"), "/" + std::string(200, 'x')}) {
    const ScopedEnvironment variable("NOTIFY_SOCKET", address.c_str());
    EXPECT_FALSE(notify("READY=1")) << address;
  }
}

}  // namespace
}  // namespace cas::base
