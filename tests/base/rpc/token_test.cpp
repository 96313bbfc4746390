// SPDX-License-Identifier: BSD-3-Clause
#include "base/rpc/token.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <iterator>
#include <nlohmann/json.hpp>
#include <vector>

#include "base/error.hpp"
#include "base/rpc/client.hpp"
#include "tests/base/rpc/raw_client.hpp"
#include "tests/base/rpc/running_server.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::base::rpc {
namespace {

constexpr const char* kToken = "correct horse battery staple";

std::filesystem::path write_token(const test::TemporaryFolder& folder, const std::string& text,
                                  mode_t mode) {
  const std::filesystem::path file = folder.write("token", text);
  ::chmod(file.c_str(), mode);
  return file;
}

TEST(Token, IsTheFirstLineOfItsFile) {
  const test::TemporaryFolder folder;
  EXPECT_EQ(read_token(write_token(folder, std::string(kToken) + "\r\nmore", 0600)), kToken);
  EXPECT_EQ(read_token(write_token(folder, kToken, 0400)), kToken);
  EXPECT_EQ(read_token(write_token(folder, "\xef\xbb\xbf" + std::string(kToken), 0600)), kToken);
}

TEST(Token, AFileThatOthersMayReadIsRefused) {
  const test::TemporaryFolder folder;
  for (const mode_t mode : {0640U, 0604U, 0620U, 0777U}) {
    EXPECT_THROW(read_token(write_token(folder, kToken, mode)), ConfigError) << mode;
  }
}

TEST(Token, AFileOfAnotherUserIsRefused) {
  if (::geteuid() != 0) GTEST_SKIP() << "only root can make a file for another user";
  const test::TemporaryFolder folder;
  const auto file = write_token(folder, kToken, 0600);
  constexpr uid_t kSomebody = 1234;
  ASSERT_EQ(::chown(file.c_str(), kSomebody, kSomebody), 0);
  EXPECT_THROW(read_token(file), ConfigError);
}

TEST(Token, AShortOrMissingOneIsRefused) {
  const test::TemporaryFolder folder;
  EXPECT_THROW(read_token(write_token(folder, "short", 0600)), ConfigError);
  EXPECT_THROW(read_token(write_token(folder, "\n" + std::string(kToken), 0600)), ConfigError);
  EXPECT_THROW(read_token(folder.path() / "none"), ConfigError);
  EXPECT_THROW(read_token(folder.path()), ConfigError);
}

TEST(Token, OnlyTheSameTextIsTheSame) {
  EXPECT_TRUE(same_token(kToken, kToken));
  for (const char* other : {"", "correct horse battery stapl", "correct horse battery staple ",
                            "Correct horse battery staple",
                            "correct horse battery staplecorrect horse battery staple"}) {
    EXPECT_FALSE(same_token(kToken, other)) << other;
  }
  EXPECT_FALSE(same_token("", "x"));
}

TEST(Token, IsMadeForItsOwnerAloneAndOnce) {
  const test::TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "token";
  const mode_t before = ::umask(0);
  EXPECT_TRUE(make_token(file));
  ::umask(before);
  struct stat status {};
  ASSERT_EQ(::lstat(file.c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777U, 0600U);
  const std::string made = read_token(file);
  EXPECT_EQ(made.size(), 64U);
  EXPECT_EQ(made.find_first_not_of("0123456789abcdef"), std::string::npos);
  EXPECT_FALSE(make_token(file));
  EXPECT_EQ(read_token(file), made);
  EXPECT_TRUE(make_token(folder.path() / "other"));
  EXPECT_NE(read_token(folder.path() / "other"), made);
}

TEST(Token, IsNeverMadeThroughASymlink) {
  const test::TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "token";
  const std::filesystem::path target = folder.path() / "elsewhere";
  ASSERT_EQ(::symlink(target.c_str(), file.c_str()), 0);
  EXPECT_FALSE(make_token(file));
  EXPECT_FALSE(std::filesystem::exists(target));
  EXPECT_THROW(read_token(file), ConfigError);
}

TEST(Token, ThatCannotBeMadeLeavesNothing) {
  const test::TemporaryFolder folder;
  EXPECT_THROW(make_token(folder.path() / "no" / "token"), ConfigError);
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

TEST(Token, ProgramsThatStartTogetherShareOne) {
  const test::TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "token";
  std::vector<pid_t> programs;
  for (int i = 0; i < 8; ++i) {
    const pid_t pid = ::fork();
    if (pid == 0) {  // each program reads a whole token
      make_token(file);
      ::_exit(read_token(file).size() == 64 ? 0 : 1);
    }
    programs.push_back(pid);
  }
  for (const pid_t pid : programs) {
    int status = 0;
    ASSERT_EQ(::waitpid(pid, &status, 0), pid);
    EXPECT_EQ(status, 0);
  }
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()), {}), 1);
}

TEST(TokenServer, ClientsOfThisMachineMayBeExempt) {
  const test::TemporaryFolder folder;
  RunningServer server;
  const auto file = write_token(folder, kToken, 0600);
  server.run([&] { server.server().require_token(file, true); });
  EXPECT_EQ(Client(server.address()).call("echo", {1}, kPatience), Json({1}));
}

TEST(TokenServer, TcpClientsMustKnowIt) {
  const test::TemporaryFolder folder;
  RunningServer server;
  const auto file = write_token(folder, kToken, 0600);
  server.run([&] { server.server().require_token(file); });
  Client client(server.address());
  try {
    client.call("echo", Json::array(), kPatience);
    FAIL() << "was called without a token";
  } catch (const CallError& error) {
    EXPECT_EQ(error.code(), kNotAuthorised);
  }
  EXPECT_EQ(client.call("authorise", {{"token", kToken}}, kPatience), true);
  EXPECT_EQ(client.call("echo", {1}, kPatience), Json({1}));
}

TEST(TokenServer, AWrongTokenEndsTheConnection) {
  const test::TemporaryFolder folder;
  RunningServer server;
  const auto file = write_token(folder, kToken, 0600);
  server.run([&] { server.server().require_token(file); });
  Client client(server.address());
  EXPECT_THROW(client.call("authorise", {{"token", "wrong"}}, kPatience), CallError);
  EXPECT_THROW(client.call("echo", {1}, kPatience), ConnectionError);
}

TEST(TokenServer, AClientThatIsNotAuthorisedInTimeIsClosed) {
  const test::TemporaryFolder folder;
  RunningServer server(ServerLimits{.first_request_time = std::chrono::seconds(1)});
  const auto file = write_token(folder, kToken, 0600);
  server.run([&] { server.server().require_token(file); });
  RawClient stranger(server.port());
  Client owner(server.address());
  EXPECT_EQ(owner.call("authorise", {{"token", kToken}}, kPatience), true);
  const Json request{{"jsonrpc", "2.0"}, {"id", 1}, {"method", "echo"}};
  EXPECT_EQ(stranger.ask(request.dump())["error"]["code"], kNotAuthorised);
  const Json end = stranger.json();
  EXPECT_TRUE(end["id"].is_null());
  EXPECT_EQ(end["error"]["code"], kNotAuthorised);
  EXPECT_TRUE(stranger.closed_by_server());
  stranger.close();
  EXPECT_TRUE(server.wait_for_refused(Refusal::kNoRequest, 1));
  EXPECT_EQ(owner.call("echo", {1}, kPatience), Json({1}));
}

TEST(TokenServer, AnAddressThatOtherHostsReachNeedsOne) {
  const test::TemporaryFolder folder;
  boost::asio::io_context io;
  Server server(io);
  EXPECT_THROW(server.listen_tcp("0.0.0.0", 0), ConfigError);
  server.require_token(write_token(folder, kToken, 0600));
  EXPECT_GT(server.listen_tcp("0.0.0.0", 0), 0);
}

}  // namespace
}  // namespace cas::base::rpc
