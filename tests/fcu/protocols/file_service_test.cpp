// SPDX-License-Identifier: BSD-3-Clause
// The controller's files, and how much of the line they take.
#include <gtest/gtest.h>

#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>

#include "fcu/emulator/served_folder.hpp"
#include "fcu/flight_controller.hpp"
#include "mavlink/common/autopilot_version.hpp"
#include "mavlink/common/command_long.hpp"
#include "mavlink_gen/runtime/codec.hpp"
#include "mavlink_gen/services/address.hpp"
#include "mavlink_gen/services/ftp_exchange.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::fcu {
namespace {

using namespace std::chrono_literals;
using mav::services::FtpExchange;
using mav::services::FtpResult;
using mav::services::Outcome;
using mavlink::common::FileTransferProtocol;

constexpr mav::Source kStation{255, 190};

/// A controller on a line of this preset, and a client, on a virtual clock.
class FileService {
 public:
  explicit FileService(const std::string& preset)
      : controller_(config(preset), [this](std::span<const std::uint8_t> packet) {
          const mav::PacketView view = mav::view_packet(packet);
          if (const auto version = mav::decode<mavlink::common::AutopilotVersion>(view)) {
            capabilities = version->capabilities;
          }
          if (view.message_id != FileTransferProtocol::kId) return;
          bytes += packet.size();
          longest = std::max(longest, packet.size());
          arrived_.emplace_back(packet.begin(), packet.end());
        }) {}

  template <class Message>
  void send(const Message& message) {
    const auto to_vehicle = mav::services::addressed(message, {1, 1});
    std::array<std::uint8_t, mav::kMaxPacketBytes> packet{};
    const std::size_t size = mavlink_version == 1 ? mav::encode_v1(to_vehicle, kStation, 0, packet)
                                                  : mav::encode(to_vehicle, kStation, 0, packet);
    controller_.on_packet(mav::view_packet(std::span(packet).first(size)), now);
  }
  void serve(ServedFolder& folder) { controller_.serve(folder); }
  /// Until the transfer ends.
  void run() {
    for (int i = 0; i < 100'000 && client.busy(); ++i) {
      now += 1ms;
      controller_.tick(now);
      const auto packets = std::exchange(arrived_, {});
      for (const auto& packet : packets) client.on_packet(mav::view_packet(packet), kStation, now);
      client.tick(now);
    }
  }

  base::RunTime now{1s};
  int mavlink_version = 2;  ///< of the requests
  std::size_t bytes = 0;
  std::size_t longest = 0;
  mavlink::common::MavProtocolCapability capabilities{};
  FtpExchange client{[this](const auto& message) { send(message); }};

 private:
  static FcuConfig config(const std::string& preset) {
    const std::string file = cas::test::source_dir() + "/config/fcu/iris_paper.yaml";
    FcuConfig config = FcuConfig::load(file);
    config.line = LineConfig::from_preset(preset);
    return config;
  }

  std::vector<std::vector<std::uint8_t>> arrived_;
  FlightController controller_;
};

TEST(FileService, TellsOfItselfAndServesTheParameters) {
  FileService service("ideal");
  mavlink::common::CommandLong request{.command = mavlink::common::MavCmd::kRequestMessage,
                                       .param1 = mavlink::common::AutopilotVersion::kId};
  service.send(request);
  EXPECT_TRUE(has(service.capabilities, mavlink::common::MavProtocolCapability::kFtp));

  std::string text;
  bool checked = false;
  service.client.download("/params.txt", service.now, [&](const Outcome& o, const FtpResult& r) {
    EXPECT_EQ(o.message, "");
    checked = r.checked;
    text.assign(r.bytes.begin(), r.bytes.end());
  });
  service.run();
  EXPECT_TRUE(checked);
  EXPECT_NE(text.find("MC_ROLL_P "), std::string::npos) << text;
  service.client.remove("params.txt", service.now, [&](const Outcome& o, const FtpResult&) {
    EXPECT_EQ(o.message,
              "removing 'params.txt': the vehicle says that it must not be changed "
              "(FileProtected)");
  });
  service.run();
  EXPECT_FALSE(service.client.busy());
}

/// A transfer at 921600 baud.
class FileServiceOnALine : public testing::Test {
 protected:
  static constexpr double kLine_b_s = 92'160;
  static constexpr double kLeft_b_s = kLine_b_s - 28'000;

  FtpExchange::Done done() {
    return [this](const Outcome& outcome, const FtpResult& result) {
      outcome_ = outcome;
      result_ = result;
    };
  }
  /// Runs the begun transfer, and checks its share of the line.
  void run() {
    const base::RunTime begin = service_.now;
    service_.run();
    ASSERT_FALSE(service_.client.busy());
    EXPECT_EQ(outcome_.message, "");
    EXPECT_GT(service_.bytes, 2000U);
    EXPECT_LE(static_cast<double>(service_.bytes - service_.longest),
              0.5 * kLeft_b_s * base::to_seconds(service_.now - begin));
    EXPECT_LE(static_cast<double>(service_.longest), 0.001 * kLine_b_s);  // a millisecond
  }

  FileService service_{"baud_921600"};
  Outcome outcome_;
  FtpResult result_;
};

TEST_F(FileServiceOnALine, LeavesItToTheHilStream) {
  service_.client.download("params.txt", service_.now, done());
  run();
}

TEST_F(FileServiceOnALine, LeavesItToTheHilStreamWhenAskedInMavlink1) {
  service_.mavlink_version = 1;
  service_.client.download("params.txt", service_.now, done());
  run();
}

TEST_F(FileServiceOnALine, LeavesItToTheHilStreamWhenItLists) {
  cas::test::TemporaryFolder folder;
  for (int i = 0; i < 200; ++i) folder.write("file_number_" + std::to_string(i), "");
  ServedFolder served(folder.path());
  service_.serve(served);
  service_.client.list("files", service_.now, done());
  run();
  EXPECT_EQ(result_.entries.size(), 200U);
}

TEST(ServedFolder, WhatHasTakenAFilesPlaceIsNotWaitedFor) {
  cas::test::TemporaryFolder folder;
  const auto file = folder.write("a", "abc");
  ServedFolder served(folder.path());
  std::array<std::uint8_t, 10> buffer{};
  std::span<std::uint8_t> bytes(buffer);
  EXPECT_FALSE(served.read("a", 1, bytes).failed());
  EXPECT_EQ(bytes.size(), 2U);
  std::filesystem::remove(file);
  ASSERT_EQ(::mkfifo(file.c_str(), 0600), 0);
  EXPECT_TRUE(served.read("a", 0, bytes).failed());
  std::uint32_t length = 0;
  EXPECT_EQ(served.length("a", length).code, mavlink::common::MavFtpErr::kFilenotfound);
}

TEST(ServedFolder, FileThatMayNotBeReadIsNoEmptyOne) {
  if (::geteuid() == 0) GTEST_SKIP() << "root may read everything";
  cas::test::TemporaryFolder folder;
  ASSERT_EQ(::chmod(folder.write("a", "abc").c_str(), 0), 0);
  ServedFolder served(folder.path());
  std::uint32_t length = 0;
  EXPECT_EQ(served.length("a", length).code, mavlink::common::MavFtpErr::kFailerrno);
  std::array<std::uint8_t, 10> buffer{};
  std::span<std::uint8_t> bytes(buffer);
  EXPECT_EQ(served.read("a", 0, bytes).error_number, EACCES);
}

TEST(ServedFolder, ListsSoManyEntriesAndHidesLinksThatLeadOut) {
  cas::test::TemporaryFolder folder;
  folder.write("secret", "");
  folder.write("served/file", "abc");
  std::filesystem::create_symlink("file", folder / "served/in");
  std::filesystem::create_symlink("../secret", folder / "served/out");
  ServedFolder served(folder / "served");
  std::vector<mav::services::FtpEntry> entries;
  EXPECT_FALSE(served.list("", entries).failed());
  EXPECT_EQ(entries, (std::vector<mav::services::FtpEntry>{{false, "file", 3}, {false, "in", 3}}));
  for (int i = 0; i < 8200; ++i) folder.write("served/many/" + std::to_string(i), "");
  entries.clear();
  EXPECT_FALSE(served.list("many", entries).failed());
  EXPECT_EQ(entries.size(), 8192U);
}

}  // namespace
}  // namespace cas::fcu
