// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "mavlink/common/setup_signing.hpp"
#include "tests/loopback/casd_fixture.hpp"

namespace cas::test {
namespace {

using mavlink::common::CommandLong;
using mavlink::common::Heartbeat;
using mavlink::common::SetupSigning;

// The routes name two messages; the sniffer is in none of them.
constexpr const char* kSnifferTopology = R"(schema: 1
links:
  - {name: sim, type: udp, local: "127.0.0.1:0", remote: "$SIM", queue: {hil_max_age_ms: 60000}}
  - {name: fcu, type: serial, device: "$FCU", queue: {hil_max_age_ms: 60000}}
  - {name: tap, type: udp_server, local: "127.0.0.1:0", sniffer: true}
routes:
  - {from: [sim, tap], to: fcu, allow: [HIL_SENSOR, COMMAND_LONG]}
  - {from: any, to: sim, allow: [HEARTBEAT]}
)";

class CasdSniffer : public testing::Test {
 protected:
  CasdSniffer() {
    fixture.start(kSnifferTopology);
    for (UdpPeer* peer : {&first, &second}) {
      peer->set_remote(fixture.port("tap"));
      peer->send(of_listener(Heartbeat{}));
    }
    // A peer is known a moment before its packet is counted.
    EXPECT_TRUE(wait_until([&] {
      const casd::LinkStatus tap = fixture.status("tap");
      return tap.peers == 2 && tap.rx.not_accepted == 2;
    }));
  }
  bool both_have(std::uint32_t message_id, std::size_t count) {
    return fixture.collect_until([&] {
      first.read(at_first);
      second.read(at_second);
      return at_first.count(message_id) >= count && at_second.count(message_id) >= count;
    });
  }
  CasdFixture fixture;
  UdpPeer first;
  UdpPeer second;
  PacketStream at_first;
  PacketStream at_second;
  mav::Encoder of_listener{{77, 1}};
};

TEST_F(CasdSniffer, GetsWhatNoRouteAndNoTargetWouldBringToIt) {
  fixture.fcu.write(fixture.from_fcu(Heartbeat{}));
  ASSERT_TRUE(both_have(kHeartbeat, 1)) << "casd's rules pass it to the simulator alone";
  fixture.sim.send(fixture.from_sim(CommandLong{.target_system = 1, .target_component = 1}));
  ASSERT_TRUE(both_have(CommandLong::kId, 1)) << "it is for the controller";
  ASSERT_TRUE(fixture.collect_until([&] { return fixture.at_fcu.count(CommandLong::kId) == 1; }));
  fixture.fcu.write(fixture.from_fcu(hil_controls(1)));
  ASSERT_TRUE(both_have(kHilControls, 1)) << "no rule lets it go anywhere";
  fixture.sim.send(fixture.from_sim(CommandLong{.target_system = 9, .target_component = 9}));
  ASSERT_TRUE(both_have(CommandLong::kId, 2)) << "nobody was heard with this id";

  fixture.sim.send(fixture.from_sim(hil_sensor(1)));
  ASSERT_TRUE(both_have(kHilSensor, 1));
  EXPECT_EQ(at_first.count(kHeartbeat), 1U) << "each packet comes once";
  EXPECT_EQ(fixture.at_fcu.count(CommandLong::kId), 1U);
  EXPECT_EQ(fixture.at_sim.count(kHilControls), 0U);
}

TEST_F(CasdSniffer, IsNotHeardAndCounted) {
  first.send(of_listener(hil_sensor(1)));
  first.send(of_listener(CommandLong{.target_system = 1, .target_component = 1}));
  ASSERT_TRUE(fixture.collect_until([&] { return fixture.status("tap").rx.not_accepted == 4; }))
      << "after the heartbeats of the two peers";
  // A later packet goes through, so an earlier one would have arrived.
  fixture.sim.send(fixture.from_sim(hil_sensor(2)));
  ASSERT_TRUE(fixture.collect_until([&] { return fixture.at_fcu.count(kHilSensor) == 1; }));
  EXPECT_EQ(numbers(fixture.at_fcu, kHilSensor).front(), 2U);
  EXPECT_EQ(fixture.at_fcu.packets().size(), 1U);
}

TEST_F(CasdSniffer, DoesNotGetTheKeysOfSignatures) {
  fixture.sim.send(fixture.from_sim(SetupSigning{.target_system = 1, .target_component = 1}));
  fixture.sim.send(fixture.from_sim(hil_sensor(1)));
  ASSERT_TRUE(both_have(kHilSensor, 1));
  EXPECT_EQ(at_first.count(SetupSigning::kId), 0U);
}

}  // namespace
}  // namespace cas::test
