// SPDX-License-Identifier: BSD-3-Clause
#include <fcntl.h>
#include <grp.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstring>

#include "base/error.hpp"
#include "base/os/descriptor.hpp"
#include "base/rpc/client.hpp"
#include "base/rpc/server.hpp"
#include "tests/base/rpc/running_server.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::base::rpc {
namespace {

namespace fs = std::filesystem;

class UnixServer : public testing::Test {
 protected:
  Json echo_at_the_socket() const {
    return Client("unix:" + path.string()).call("echo", {1}, kPatience);
  }
  mode_t mode() const {
    struct stat status {};
    ::stat(path.c_str(), &status);
    return status.st_mode & 0777U;
  }

  const cas::test::TemporaryFolder folder;
  fs::path path = folder.path() / "rpc";
};

void listen_unix(RunningServer& server, const fs::path& path) {
  server.run([&] { server.server().listen_unix(path); });
}

/// Leaves a socket file without a listener behind.
void leave_stale_socket(const fs::path& path) {
  const int fd = ::socket(AF_UNIX, SOCK_STREAM, 0);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::strncpy(address.sun_path, path.c_str(), sizeof address.sun_path - 1);
  EXPECT_EQ(::bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  ::close(fd);
}

TEST_F(UnixServer, AnswersAndRemovesItsFile) {
  {
    RunningServer server;
    listen_unix(server, path);
    EXPECT_EQ(echo_at_the_socket(), Json({1}));
  }
  EXPECT_FALSE(fs::exists(path));
}

TEST_F(UnixServer, TheFileIsForItsOwnerAlone) {
  const mode_t before = ::umask(0);
  RunningServer server;
  listen_unix(server, path);
  ::umask(before);
  EXPECT_EQ(mode(), 0600U);
}

TEST_F(UnixServer, AGroupMayBeLetIn) {
  const group* own = ::getgrgid(::getegid());
  ASSERT_NE(own, nullptr);
  const std::string name = own->gr_name;
  const mode_t before = ::umask(077);
  RunningServer server;
  server.run([&] { server.server().listen_unix(path, name); });
  ::umask(before);
  struct stat status {};
  ::stat(path.c_str(), &status);
  EXPECT_EQ(status.st_mode & 0777U, 0660U);
  EXPECT_EQ(status.st_gid, ::getegid());
}

TEST_F(UnixServer, AGroupThatIsNotThereIsRefused) {
  RunningServer server;
  EXPECT_THROW(server.run([&] { server.server().listen_unix(path, "no-such-group"); }),
               ConfigError);
  EXPECT_FALSE(fs::exists(path));
}

TEST_F(UnixServer, ASocketOfAnotherUserIsNotReplaced) {
  leave_stale_socket(path);
  constexpr uid_t kNobody = 65534;
  if (::lchown(path.c_str(), kNobody, kNobody) != 0) GTEST_SKIP() << "takes root";
  RunningServer server;
  EXPECT_THROW(listen_unix(server, path), ConfigError);
  EXPECT_TRUE(fs::exists(path));
}

// A program that has bound its socket and does not listen yet would look stale. In /tmp any user
// may lock the folder, so the wait is bounded.
TEST_F(UnixServer, WaitsForAnotherProgramThatIsBindingInTheFolder) {
  const Descriptor other(::open(folder.path().c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  ASSERT_EQ(::flock(other.get(), LOCK_EX), 0);
  RunningServer server;
  const RunTime start = steady_now();
  listen_unix(server, path);
  EXPECT_GE(steady_now() - start, std::chrono::milliseconds(1900)) << "it was not waited for";
  EXPECT_EQ(echo_at_the_socket(), Json({1}));
}

TEST_F(UnixServer, LeavesAFileThatHasTakenTheSocketsPlace) {
  {
    RunningServer server;
    listen_unix(server, path);
    fs::remove(path);
    folder.write("rpc", "another program's");
  }
  EXPECT_TRUE(fs::exists(path));
}

TEST_F(UnixServer, AStaleFileIsReplaced) {
  leave_stale_socket(path);
  RunningServer server;
  listen_unix(server, path);
  EXPECT_EQ(echo_at_the_socket(), Json({1}));
}

TEST_F(UnixServer, AFileInUseIsRefused) {
  RunningServer first;
  listen_unix(first, path);
  RunningServer second;
  EXPECT_THROW(listen_unix(second, path), ConfigError);
  EXPECT_EQ(echo_at_the_socket(), Json({1}));
}

TEST_F(UnixServer, AFileOfAnotherKindIsNeverRemoved) {
  path = folder.write("precious", "data");
  RunningServer server;
  EXPECT_THROW(listen_unix(server, path), ConfigError);
  EXPECT_TRUE(fs::exists(path));
}

TEST_F(UnixServer, ImpossiblePathsAreRefused) {
  RunningServer server;
  EXPECT_THROW(listen_unix(server, ""), ConfigError);
  EXPECT_THROW(listen_unix(server, "/nowhere/rpc"), ConfigError);
  EXPECT_THROW(listen_unix(server, "/tmp/" + std::string(200, 'x')), ConfigError);
}

}  // namespace
}  // namespace cas::base::rpc
