// SPDX-License-Identifier: BSD-3-Clause
// The example programs of docs/mavlink_gen.md, each run with a recorded stream.
#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <filesystem>
#include <string>

#include "mavlink/common/all.hpp"
#include "mavlink_gen/runtime/codec.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/temporary_folder.hpp"

namespace {

using namespace cas::mav;
namespace common = mavlink::common;

/// Encodes messages of system 1 to a file.
class Recording {
 public:
  template <class Message>
  void add(const Message& message) {
    const auto packet = encode_packet_(message);
    text_.append(packet.begin(), packet.end());
  }
  /// What an example program prints of it.
  std::string printed_by(const std::string& program) const {
    const cas::test::TemporaryFolder folder;
    const std::filesystem::path file = folder.write("stream", text_);
    FILE* out = ::popen(
        (cas::test::binary_dir() + "/tests/" + program + " < " + file.string()).c_str(), "r");
    if (out == nullptr) return "the program did not start";
    std::string lines;
    std::array<char, 4096> part{};
    while (const std::size_t size = std::fread(part.data(), 1, part.size(), out)) {
      lines.append(part.data(), size);
    }
    EXPECT_EQ(::pclose(out), 0);
    return lines;
  }

 private:
  Encoder encode_packet_{{.system = 1, .component = 1}};
  std::string text_;
};

TEST(Examples, InspectorPrintsTheMessagesOfItsVisitor) {
  Recording recording;
  recording.add(common::Heartbeat{.type = common::MavType::kQuadrotor,
                                  .base_mode = common::MavModeFlag::kSafetyArmed});
  recording.add(common::HilSensor{});  // has no overload
  recording.add(common::Attitude{.roll = 0.1F, .pitch = -0.2F, .yaw = 1.5F});
  EXPECT_EQ(recording.printed_by("mavlink_inspector"),
            "1/1 HEARTBEAT MAV_TYPE_QUADROTOR armed\n"
            "1/1 ATTITUDE roll 0.10 pitch -0.20 yaw 1.50 rad\n");
}

TEST(Examples, ChangesPrintsTheFieldsThatDiffer) {
  common::Heartbeat heartbeat{.type = common::MavType::kQuadrotor,
                              .custom_mode = 3,
                              .system_status = common::MavState::kStandby};
  Recording recording;
  recording.add(heartbeat);
  recording.add(heartbeat);
  heartbeat.custom_mode = 4;
  heartbeat.system_status = common::MavState::kActive;
  recording.add(heartbeat);
  EXPECT_EQ(recording.printed_by("mavlink_changes"),
            "custom_mode: 3 -> 4\n"
            "system_status: MAV_STATE_STANDBY -> MAV_STATE_ACTIVE\n");
}

}  // namespace
