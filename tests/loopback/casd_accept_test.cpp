// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "tests/loopback/casd_fixture.hpp"

namespace cas::test {
namespace {

/// A simulator's link with this `accept`, the controller's line, and nothing else.
/// On a loaded machine nothing is dropped by age.
std::string topology(const std::string& accept) {
  return R"(schema: 1
links:
  - {name: sim, type: udp_server, local: "127.0.0.1:0", accept: )" +
         accept + R"(, queue: {hil_max_age_ms: 60000}}
  - {name: fcu, type: serial, device: "$FCU", queue: {hil_max_age_ms: 60000}}
)";
}

TEST(CasdAccept, AReadOnlyLinkHearsEverythingAndSaysNothing) {
  CasdFixture fixture(topology("nothing"));
  // The sender of a whole packet still becomes a peer.
  fixture.sim.send(fixture.from_sim(mavlink::common::Heartbeat{}));
  fixture.sim.send(fixture.from_sim(mavlink::common::CommandLong{.target_system = 1}));
  ASSERT_TRUE(fixture.collect_until([&] { return fixture.status("sim").rx.not_accepted == 2; }));
  fixture.fcu.write(fixture.from_fcu(hil_controls(1)));
  ASSERT_TRUE(fixture.collect_until([&] { return fixture.at_sim.count(kHilControls) == 1; }));
  EXPECT_EQ(fixture.at_fcu.packets().size(), 0U);
  EXPECT_EQ(fixture.status("sim").rx.decisions[0], 0U);
}

TEST(CasdAccept, LimitsALinkToNamedMessagesAndSystems) {
  CasdFixture fixture(topology("{messages: [HIL_SENSOR, HEARTBEAT], systems: [1, 2]}"));
  mav::Encoder stranger{{9, 1}};
  fixture.sim.send(fixture.from_sim(hil_gps(1)));
  fixture.sim.send(stranger(hil_sensor(1)));
  fixture.sim.send(fixture.from_sim(hil_sensor(2)));
  ASSERT_TRUE(fixture.collect_until([&] { return fixture.at_fcu.count(kHilSensor) == 1; }));
  EXPECT_EQ(numbers(fixture.at_fcu, kHilSensor).front(), 2U);
  EXPECT_EQ(fixture.at_fcu.packets().size(), 1U);
  EXPECT_EQ(fixture.status("sim").rx.not_accepted, 2U);
}

TEST(CasdAccept, AFloodOfSendersTakesNothingFromTheOthers) {
  CasdFixture fixture(R"(schema: 1
links:
  - {name: sim, type: udp, local: "127.0.0.1:0", remote: "$SIM", queue: {hil_max_age_ms: 60000}}
  - {name: fcu, type: serial, device: "$FCU", queue: {hil_max_age_ms: 60000}}
  - {name: gcs, type: udp_server, local: "127.0.0.1:0"}
routes:
  - {from: sim, to: fcu}
  - {from: fcu, to: sim}
)");
  UdpPeer flood;
  flood.set_remote(fixture.port("gcs"));
  // Every id that there is: far more than any table keeps.
  constexpr std::uint64_t kSenders = 65'536;
  for (std::uint64_t i = 0; i < kSenders; ++i) {
    mav::Encoder stranger{{static_cast<std::uint8_t>(i >> 8U), static_cast<std::uint8_t>(i)}};
    flood.send(stranger(mavlink::common::Heartbeat{}));
    if (i % 128 == 127) {  // no faster than casd reads, so that every one of them counts
      ASSERT_TRUE(wait_until([&] {
        const auto rx = fixture.status("gcs").rx;
        return rx.packets + rx.kernel_drops >= i + 1;
      }));
    }
  }
  EXPECT_LE(fixture.links().figures().messages(base::steady_now(), "gcs").size(), 2048U);
  fixture.sim.send(fixture.from_sim(hil_sensor(1)));
  fixture.fcu.write(fixture.from_fcu(hil_controls(1)));
  EXPECT_TRUE(fixture.collect_until([&] {
    return fixture.at_fcu.count(kHilSensor) == 1 && fixture.at_sim.count(kHilControls) == 1;
  }));
}

}  // namespace
}  // namespace cas::test
