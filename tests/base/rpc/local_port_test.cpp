// SPDX-License-Identifier: BSD-3-Clause
#include "base/rpc/local_port.hpp"

#include <gtest/gtest.h>
#include <stdlib.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>

#include "base/error.hpp"
#include "base/rpc/listener.hpp"
#include "base/rpc/local_clients.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::base::rpc {
namespace {

namespace fs = std::filesystem;

/// A runtime folder of its own.
class LocalPort : public testing::Test {
 protected:
  LocalPort() {
    if (const char* value = ::getenv("CAS_RUNTIME_DIR")) before_ = value;
    ::setenv("CAS_RUNTIME_DIR", folder_.c_str(), 1);
  }
  ~LocalPort() override {
    before_.empty() ? ::unsetenv("CAS_RUNTIME_DIR")
                    : ::setenv("CAS_RUNTIME_DIR", before_.c_str(), 1);
  }
  static bool contains(const std::vector<fs::path>& list, const fs::path& path) {
    return std::find(list.begin(), list.end(), path) != list.end();
  }

  /// A socket that is bound there. @return its descriptor
  static int open_socket(const fs::path& path) {
    const int fd = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::strncpy(address.sun_path, path.c_str(), sizeof address.sun_path - 1);
    EXPECT_EQ(::bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    return fd;
  }
  /// A socket file without a listener.
  static void bind_socket(const fs::path& path) { ::close(open_socket(path)); }

  test::TemporaryFolder session_;
  fs::path folder_ = session_.path() / "cas";
  std::string before_;
};

TEST_F(LocalPort, KnowsTheAddressesOfThisMachine) {
  for (const char* address : {"127.0.0.1", "127.9.9.9", "::1", "localhost"}) {
    EXPECT_TRUE(is_loopback_address(address)) << address;
  }
  for (const char* address : {"0.0.0.0", "::", "192.0.2.7", "example.org", ""}) {
    EXPECT_FALSE(is_loopback_address(address)) << address;
  }
}

TEST_F(LocalPort, NamesASocketByItsTcpPort) {
  EXPECT_EQ(command_socket_name(5790), "casd.sock");
  EXPECT_EQ(command_socket_name(6000), "casd-6000.sock");
}

TEST_F(LocalPort, MakesTheFolderForItsUserAlone) {
  const mode_t before = ::umask(0);
  EXPECT_EQ(make_runtime_folder(), folder_);
  ::umask(before);
  struct stat status {};
  ASSERT_EQ(::stat(folder_.c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777U, 0700U);
  EXPECT_EQ(make_runtime_folder(), folder_) << "made before";
}

TEST_F(LocalPort, TakesNoFolderThatOthersMayWriteInto) {
  ASSERT_EQ(::mkdir(folder_.c_str(), 0777), 0);
  ASSERT_EQ(::chmod(folder_.c_str(), 0777), 0);
  session_.write("cas/casd.token", "0123456789abcdef");
  EXPECT_FALSE(contains(local_command_tokens(), folder_ / kCommandToken)) << "it may be anybody's";
  EXPECT_THROW(make_runtime_folder(), ConfigError);
  struct stat status {};
  ASSERT_EQ(::stat(folder_.c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777U, 0777U) << "its mode is its owner's affair";
}

TEST_F(LocalPort, TakesNoSymlinkForTheFolder) {
  const test::TemporaryFolder elsewhere;
  ASSERT_EQ(::symlink(elsewhere.path().c_str(), folder_.c_str()), 0);
  elsewhere.write("casd.token", "0123456789abcdef");
  EXPECT_THROW(make_runtime_folder(), ConfigError);
  EXPECT_FALSE(contains(local_command_tokens(), folder_ / kCommandToken));
}

TEST_F(LocalPort, FindsSocketAndTokenOfItsUser) {
  make_runtime_folder();
  const fs::path path = folder_ / "casd.sock";
  const fs::path token = folder_ / kCommandToken;
  EXPECT_FALSE(contains(local_command_sockets(), path));
  EXPECT_FALSE(contains(local_command_tokens(), token));
  bind_socket(path);
  session_.write("cas/casd.token", "0123456789abcdef");
  EXPECT_TRUE(contains(local_command_sockets(), path));
  EXPECT_TRUE(contains(local_command_tokens(), token));
}

TEST_F(LocalPort, FindsEveryCasdsSocketAndNothingElse) {
  make_runtime_folder();
  for (const char* name : {"casd.sock", "casd-6000.sock", "casd-lab.sock", "other.sock"}) {
    bind_socket(folder_ / name);
  }
  session_.write("cas/casd-file.sock", "no socket");
  std::vector<fs::path> own = local_command_sockets();
  std::erase_if(own, [this](const fs::path& path) { return path.parent_path() != folder_; });
  EXPECT_EQ(own, (std::vector<fs::path>{folder_ / "casd-6000.sock", folder_ / "casd-lab.sock",
                                        folder_ / "casd.sock"}));
}

TEST_F(LocalPort, LeavesOutASocketOfAnotherUser) {
  if (::geteuid() != 0) GTEST_SKIP() << "root alone gives files away";
  make_runtime_folder();
  const fs::path path = folder_ / "casd.sock";
  bind_socket(path);
  ASSERT_TRUE(contains(local_command_sockets(), path));
  constexpr uid_t kNobody = 65534;
  ASSERT_EQ(::lchown(path.c_str(), kNobody, static_cast<gid_t>(-1)), 0);
  EXPECT_FALSE(contains(local_command_sockets(), path));
}

TEST_F(LocalPort, ConnectsToThoseThatListen) {
  make_runtime_folder();
  bind_socket(folder_ / "casd-1.sock");
  const int listening = open_socket(folder_ / "casd-2.sock");
  ASSERT_EQ(::listen(listening, 1), 0);
  std::vector<std::string> found;
  for (const LocalClient& local : connect_local()) found.push_back(local.address);
  ::close(listening);
  std::erase_if(found, [this](const std::string& address) {
    return address.find(folder_.string()) == std::string::npos;
  });
  EXPECT_EQ(found, std::vector<std::string>{"unix:" + (folder_ / "casd-2.sock").string()});
}

TEST_F(LocalPort, RemovesSocketsThatNobodyListensOn) {
  make_runtime_folder();
  bind_socket(folder_ / "casd-1.sock");
  bind_socket(folder_ / "other.sock");
  const int listening = open_socket(folder_ / "casd-2.sock");
  ASSERT_EQ(::listen(listening, 1), 0);
  remove_stale_sockets(folder_);
  EXPECT_FALSE(fs::exists(folder_ / "casd-1.sock"));
  EXPECT_TRUE(fs::exists(folder_ / "casd-2.sock")) << "it is in use";
  EXPECT_TRUE(fs::exists(folder_ / "other.sock")) << "it is no casd's";
  ::close(listening);
}

}  // namespace
}  // namespace cas::base::rpc
