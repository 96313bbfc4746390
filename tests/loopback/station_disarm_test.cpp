// SPDX-License-Identifier: BSD-3-Clause
// hils does not re-arm a vehicle that a person has disarmed: in real time, through casd.
#include <gtest/gtest.h>

#include <chrono>
#include <optional>
#include <string>

#include "base/time/clock.hpp"
#include "mavlink/common/all.hpp"
#include "mavlink_gen/runtime/codec.hpp"
#include "tests/support/child_process.hpp"
#include "tests/support/free_port.hpp"
#include "tests/support/packet_stream.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/support/udp_peer.hpp"
#include "tests/support/wait_until.hpp"

namespace cas::test {
namespace {

/// A person arms and disarms before hils is to arm.
TEST(StationDisarm, IsNotUndoneByARunInRealTime) {
  namespace mv = mavlink::common;
  const TemporaryFolder folder;
  const std::string scenario = folder
                                   .write("own.yaml",
                                          "schema: 1\nname: own\ndescription: A disarm\n"
                                          "vehicle: " +
                                              source_dir() +
                                              R"(/config/vehicles/iris_paper.yaml
architecture: tcas
home: {lat_deg: 47.397742, lon_deg: 8.545594, alt_m: 488.0}
decimal_year: 2026.5
seed: 1
rates: {sensor_hz: 250, gps_hz: 5, controls_hz: 250}
line: {preset: baud_921600}
steps:
  - wait_until: {condition: armed > 0.5, timeout_s: 120}
  - wait_until: {condition: armed < 0.5, timeout_s: 120}
  - arm
  - takeoff: {altitude_m: 2}
  - hold: {duration_s: 1, measure: true}
  - land
  - disarm
)")
                                   .string();
  UdpPeer station;
  const std::uint16_t port = free_port();
  station.set_remote(port);
  ChildProcess hils({binary_dir() + "/bin/hils", "run", scenario, "--out", folder / "out", "--gcs",
                     "udp_server:" + std::to_string(port)});
  mav::Encoder as_station{{255, 190}};
  bool armed = false;
  int armed_beats = 0;
  bool disarm_sent = false;  // a busy machine's vehicle may disarm by itself before
  bool disarmed = false;
  int armed_again = 0;
  std::optional<int> code;
  base::RunTime say_at{};
  wait_until(
      [&] {
        PacketStream heard;
        station.read(heard);
        for (const PacketStream::Packet& packet : heard.packets()) {
          const auto beat = mav::decode<mv::Heartbeat>(packet.view());
          if (beat && packet.view().source == mav::Source{1, 1}) {
            armed = has(beat->base_mode, mv::MavModeFlag::kSafetyArmed);
            armed_again += armed && disarmed ? 1 : 0;
            armed_beats += armed ? 1 : 0;
            disarmed = disarmed || (!armed && disarm_sent);
          }
        }
        const bool seen_by_hils = armed_beats >= 3;
        if (!disarmed && (!armed || seen_by_hils) && base::steady_now() > say_at) {
          mv::CommandLong command;
          command.target_system = command.target_component = 1;
          command.command = mv::MavCmd::kComponentArmDisarm;
          disarm_sent = disarm_sent || seen_by_hils;
          command.param1 = disarm_sent ? 0 : 1;
          station.send(as_station(command));
          say_at = base::steady_now() + std::chrono::milliseconds(200);
        }
        code = hils.wait_exit(base::Duration::zero());
        return code.has_value();
      },
      std::chrono::minutes(3));
  // Not complete, or, on a busy machine, not judged: it may end before the person disarms.
  EXPECT_TRUE(code == 1 || code == 3) << hils.output();
  EXPECT_TRUE(disarmed || code == 3) << hils.output();
  EXPECT_EQ(armed_again, 0) << hils.output();
}

}  // namespace
}  // namespace cas::test
