// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>

#include <nlohmann/json.hpp>
#include <vector>

#include "base/rpc/client.hpp"
#include "tests/loopback/casd_fixture.hpp"
#include "tests/loopback/running_casd.hpp"
#include "tests/support/line_rate.hpp"

namespace cas::test {
namespace {

using nlohmann::json;
using testing::HasSubstr;

/// A vehicle on the line that is understood at one rate only.
class Vehicle {
 public:
  Vehicle(CasdFixture& fixture, unsigned baud) : fixture_(fixture), baud_(baud) {}

  /// The rate that casd has set.
  unsigned line() const { return line_rate(fixture_.fcu.master()); }
  /// Sends one packet, garbled if the receiver's rate differs.
  void speak() {
    const auto packet = fixture_.from_fcu(hil_controls(++sent_));
    std::vector<std::uint8_t> bytes(packet.begin(), packet.end());
    if (line() != baud_) {
      for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(byte ^ 0xA5U);
    }
    fixture_.fcu.write(bytes);
  }

 private:
  CasdFixture& fixture_;
  unsigned baud_;
  std::uint64_t sent_ = 0;
};

constexpr const char* kTopology = R"(schema: 1
command_port: {port: 0, loopback_without_token: true}
commanding: {heartbeat_hz: 50}
links:
  - {name: sim, type: udp, local: "127.0.0.1:0", remote: "$SIM", queue: {hil_max_age_ms: 60000}}
  - {name: fcu, type: serial, device: "$FCU", baud: [57600, 921600],
     queue: {hil_max_age_ms: 60000}}
)";

TEST(CasdBaud, OfAListTheRateAtWhichPacketsComeIsKeptAndTold) {
  CasdFixture fixture;
  RunningCasd casd(
      {kCasdProgram, fixture.folder.write("topology.yaml", fixture.expand(kTopology))});
  const auto endpoint = [&](const std::string& name) { return word_after(casd.status, name); };
  base::rpc::Client client(endpoint("command_port"));
  const auto link = [&] { return client.call("link.list", json::object()).at(1); };
  ASSERT_TRUE(wait_until([&] { return link().at("state") == "down"; }));
  EXPECT_THAT(link().at("endpoint").get<std::string>(),
              HasSubstr("listens for MAVLink at 57600 or 921600 baud"));
  EXPECT_FALSE(link().contains("baud"));

  Vehicle vehicle(fixture, 921'600);
  ASSERT_TRUE(wait_until([&] { return vehicle.line() == 57'600U; }));
  ASSERT_TRUE(fixture.collect_until([&] {
    vehicle.speak();
    if (vehicle.line() == 57'600U) {
      EXPECT_EQ(fixture.at_fcu.packets().size(), 0U);
    }
    return fixture.at_sim.count(kHilControls) > 0;
  })) << casd.output();
  EXPECT_EQ(fixture.at_fcu.garbage(), 0U);
  EXPECT_EQ(vehicle.line(), 921'600U);
  EXPECT_EQ(link().at("state"), "up");
  EXPECT_EQ(link().at("baud"), 921'600);
  EXPECT_THAT(casd.output(), HasSubstr("link fcu: up, " + fixture.expand("$FCU") + " 921600"));
  ASSERT_TRUE(fixture.collect_until([&] { return fixture.at_fcu.count(kHeartbeat) > 0; }))
      << "casd speaks, too";
}

TEST(CasdBaud, AVehicleThatComesBackWithAnotherRateIsFoundOnTheOpenLine) {
  CasdFixture fixture(kTopology);
  const auto up_at = [&](Vehicle& vehicle, std::uint64_t baud) {
    return fixture.collect_until([&] {
      vehicle.speak();
      const casd::LinkStatus link = fixture.status("fcu");
      return link.state == casd::LinkState::kUp && link.baud == baud;
    });
  };
  Vehicle slow(fixture, 57'600);
  ASSERT_TRUE(up_at(slow, 57'600));
  Vehicle fast(fixture, 921'600);
  EXPECT_TRUE(up_at(fast, 921'600));
}

TEST(CasdBaud, AfterADeviceHasReturnedItsRateIsLookedForAgain) {
  CasdFixture fixture(kTopology);
  const auto is_up = [&] { return fixture.status("fcu").state == casd::LinkState::kUp; };
  const auto hear = [&](Vehicle& vehicle) {
    return fixture.collect_until([&] {
      vehicle.speak();
      return is_up();
    });
  };
  Vehicle slow(fixture, 57'600);
  ASSERT_TRUE(hear(slow));
  EXPECT_EQ(fixture.status("fcu").baud, 57'600U);

  fixture.fcu.hang_up();
  ASSERT_TRUE(wait_until([&] { return !is_up(); }));
  fixture.fcu.come_back();
  Vehicle fast(fixture, 921'600);
  ASSERT_TRUE(wait_until([&] { return fast.line() == 57'600U; })) << "what was right is tried";
  ASSERT_TRUE(hear(fast));
  EXPECT_EQ(fixture.status("fcu").baud, 921'600U);

  fixture.fcu.hang_up();
  ASSERT_TRUE(wait_until([&] { return !is_up(); }));
  fixture.fcu.come_back();
  ASSERT_TRUE(wait_until([&] { return fast.line() == 921'600U; }));
  ASSERT_TRUE(hear(fast));
}

}  // namespace
}  // namespace cas::test
