// SPDX-License-Identifier: BSD-3-Clause
// The controller's files, and how much of the line they take.
#include <gtest/gtest.h>

#include "fcu/flight_controller.hpp"
#include "mavlink/common/autopilot_version.hpp"
#include "mavlink/common/command_long.hpp"
#include "mavlink_gen/runtime/codec.hpp"
#include "mavlink_gen/services/address.hpp"
#include "mavlink_gen/services/ftp_exchange.hpp"
#include "tests/support/paths.hpp"

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
    const auto packet = encode_packet_(mav::services::addressed(message, {1, 1}));
    controller_.on_packet(mav::view_packet(packet), now);
  }
  /// Until the transfer ends.
  void run() {
    for (int i = 0; i < 100'000 && client.busy(); ++i) {
      now += 5ms;
      controller_.tick(now);
      const auto packets = std::exchange(arrived_, {});
      for (const auto& packet : packets) client.on_packet(mav::view_packet(packet), kStation, now);
      client.tick(now);
    }
  }

  base::RunTime now{1s};
  std::size_t bytes = 0;
  std::size_t longest = 0;
  mavlink::common::MavProtocolCapability capabilities{};
  FtpExchange client{[this](const auto& message) { send(message); }};

 private:
  static FcuConfig config(const std::string& preset) {
    const std::string file = test::source_dir() + "/config/fcu/iris_paper.yaml";
    FcuConfig config = FcuConfig::load(file);
    config.line = LineConfig::from_preset(preset);
    return config;
  }

  mav::Encoder encode_packet_{kStation};
  std::vector<std::vector<std::uint8_t>> arrived_;
  FlightController controller_;
};

TEST(FileService, TellsOfItselfAndServesTheParameters) {
  FileService service("ideal");
  mavlink::common::CommandLong request;
  request.command = mavlink::common::MavCmd::kRequestMessage;
  request.param1 = mavlink::common::AutopilotVersion::kId;
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

TEST(FileService, LeavesTheLineToTheHilStream) {
  constexpr double kLine_b_s = 92'160;
  constexpr double kLeft_b_s = kLine_b_s - 28'000;
  FileService service("baud_921600");
  bool ok = false;
  service.client.download("params.txt", service.now,
                          [&](const Outcome& o, const FtpResult&) { ok = o.ok(); });
  const base::RunTime begin = service.now;
  service.run();
  EXPECT_TRUE(ok);
  EXPECT_GT(service.bytes, 2000U);
  EXPECT_LE(static_cast<double>(service.bytes),
            0.5 * kLeft_b_s * base::to_seconds(service.now - begin));
  EXPECT_LE(static_cast<double>(service.longest), 0.001 * kLine_b_s);  // a millisecond
}

}  // namespace
}  // namespace cas::fcu
