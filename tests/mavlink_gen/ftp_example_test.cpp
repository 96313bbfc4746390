// SPDX-License-Identifier: BSD-3-Clause
// The example program ftp_download against the emulated controller on its pseudo-terminal.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <array>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>

#include "mavlink_gen/runtime/codec.hpp"
#include "mavlink_gen/runtime/encode.hpp"
#include "tests/mavlink_gen/services/memory_ftp_store.hpp"
#include "tests/support/child_process.hpp"
#include "tests/support/packet_stream.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/pty_pair.hpp"
#include "tests/support/temporary_folder.hpp"

namespace {

/// An emulator that serves a folder over a line that loses packets.
class FtpDownload : public testing::Test {
 protected:
  void SetUp() override { ASSERT_TRUE(emulator_.wait_ready()) << emulator_.output(); }

  /// Output of the program, errors too.
  std::string fetched(const std::string& path, int exit_code = 0) {
    const std::string command =
        cas::test::binary_dir() + "/tests/mavlink_ftp_download " + line_ + ' ' + path + " 2>&1";
    FILE* out = ::popen(command.c_str(), "r");
    if (out == nullptr) return "the program did not start";
    std::string text;
    std::array<char, 4096> part{};
    while (const std::size_t size = std::fread(part.data(), 1, part.size(), out)) {
      text.append(part.data(), size);
    }
    EXPECT_EQ(WEXITSTATUS(::pclose(out)), exit_code) << path;
    return text;
  }
  /// The folder that is served; beside it lies a file that is not.
  std::string serve() {
    folder_.write("secret", "no one's business");
    std::filesystem::create_directories(folder_ / "served/log");
    folder_.write("served/log/a.ulg", log_);
    folder_.write("served/empty", "");
    std::filesystem::create_symlink("log/a.ulg", folder_ / "served/newest");
    std::filesystem::create_symlink(folder_ / "secret", folder_ / "served/out");
    std::filesystem::create_symlink("..", folder_ / "served/up");
    return (folder_ / "served").string();
  }

  cas::test::TemporaryFolder folder_;
  std::string log_ = [] {
    std::string bytes;
    for (unsigned i = 0; bytes.size() < 40'000; i = i * 1103515245U + 12345U) {
      bytes += static_cast<char>(i >> 16U);
    }
    return bytes;
  }();
  std::string line_ = (folder_ / "fcu0").string();
  cas::test::ChildProcess emulator_{
      {cas::test::binary_dir() + "/bin/fcu_emulator",
       folder_
           .write("fcu.yaml", "schema: 1\nvehicle: " + cas::test::source_dir() +
                                  "/config/vehicles/iris_paper.yaml\n"
                                  "line: {packet_loss: 0.05, packet_duplicate: 0.05}\n")
           .string(),
       "--link", line_, "--files", serve()}};
};

TEST_F(FtpDownload, ListsAndFetchesOverALineThatLosesPackets) {
  const std::string top = fetched("/");
  EXPECT_TRUE(top.starts_with("params.txt  ")) << top;
  EXPECT_TRUE(top.ends_with("\nfiles/\n")) << top;
  EXPECT_EQ(fetched("files/"), "empty  0\nlog/\nnewest  40000\n");
  folder_.write("served/later", "abc");  // another run gets no answer of the one before
  EXPECT_EQ(fetched("files/"), "empty  0\nlater  3\nlog/\nnewest  40000\n");
  EXPECT_EQ(fetched("/files/log/"), "a.ulg  40000\n");
  EXPECT_TRUE(fetched("files/log/a.ulg") == log_);
  EXPECT_EQ(fetched("files/empty"), "");
  const std::string params = fetched("/params.txt");
  EXPECT_NE(params.find("\nSYS_AUTOSTART "), std::string::npos) << params;
}

TEST_F(FtpDownload, NothingLeadsOutOfWhatIsServed) {
  for (const std::string path :
       {"secret", "files/out", "files/up/secret", "files/../secret", "/etc/passwd", "files/none"}) {
    EXPECT_EQ(fetched(path, 1), "reading '" + path +
                                    "': the vehicle says that there is no such file or folder "
                                    "(FileNotFound)\n");
  }
}

/// A vehicle of the test's own, whose line goes dead after so many packets.
class FtpDownloadOfAVehicle : public testing::Test {
 protected:
  /// @param to  where standard output goes
  /// @return the exit code
  std::optional<int> run(const std::string& path, const std::string& to) {
    cas::test::ChildProcess program({"/bin/sh", "-c",
                                     cas::test::binary_dir() + "/tests/mavlink_ftp_download " +
                                         line_.slave() + ' ' + path + " > " + to});
    std::optional<int> code;
    cas::test::PacketStream asked;
    const auto give_up = Clock::now() + cas::test::kPatience;
    while (!(code = program.wait_exit(std::chrono::milliseconds(1))) && Clock::now() < give_up) {
      line_.read(asked);
      for (const auto& packet : std::exchange(asked.packets(), {})) {
        const auto request = cas::mav::decode<FtpServer::Message>(packet.view());
        if (request) server_.on_request(*request, packet.source, Clock::now());
      }
      server_.update(Clock::now());
    }
    said_ = program.output();
    return code;
  }

  using Clock = std::chrono::steady_clock;
  using FtpServer = cas::mav::services::FtpServer;
  cas::test::TemporaryFolder folder_;
  cas::test::PtyPair line_;
  cas::mav::Encoder encode_packet_{{.system = 1, .component = 1}};
  int packets_ = 1000;  ///< that the line still takes
  std::string said_;
  cas::mav::services::MemoryFtpStore store_;
  FtpServer server_{store_, [this](const FtpServer::Message& message) {
                      const auto packet = encode_packet_(message);
                      if (packets_-- > 0) line_.write(packet);
                      return packet.size();
                    }};
};

TEST_F(FtpDownloadOfAVehicle, TransferThatIsCutLeavesNothing) {
  store_.files["a"].assign(5000, 7);
  const std::string file = (folder_ / "a").string();
  EXPECT_EQ(run("a", file), 0);
  EXPECT_EQ(cas::test::TemporaryFolder::read(file), std::string(5000, 7));
  packets_ = 5;  // the opening and four pieces
  EXPECT_EQ(run("a", file), 1);
  EXPECT_EQ(cas::test::TemporaryFolder::read(file), "");
  EXPECT_EQ(said_, "reading 'a', 956 of 5000 bytes, then nothing more came\n");
}

TEST_F(FtpDownloadOfAVehicle, OutputThatCannotBeWrittenIsAFailure) {
  store_.files["a"].assign(5000, 7);
  EXPECT_EQ(run("a", "/dev/full"), 1);
  EXPECT_EQ(said_, "standard output cannot be written\n");
}

TEST_F(FtpDownloadOfAVehicle, NamesDoNotSteerTheTerminal) {
  store_.files["a\x1b[2J\x7f\xc3\xa4"];
  const std::string file = (folder_ / "list").string();
  EXPECT_EQ(run("/", file), 0);
  EXPECT_EQ(cas::test::TemporaryFolder::read(file), "a?[2J?\xc3\xa4  0\n");
}

}  // namespace
