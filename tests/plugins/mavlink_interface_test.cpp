// SPDX-License-Identifier: BSD-3-Clause
#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <unistd.h>

#include <deque>
#include <string>
#include <vector>

#include "mavlink/common/all.hpp"
#include "plugins/mavlink_interface/hil_conversion.hpp"
#include "plugins/mavlink_interface/hil_interface.hpp"
#include "plugins/mavlink_interface/udp_port.hpp"
#include "tests/plugins/plugin_harness.hpp"

namespace cas::sim {
namespace {

namespace mv = mavlink::common;
using std::chrono::milliseconds;

constexpr base::Duration kPatience = std::chrono::seconds(10);  // deadline, not a wait

/// Keeps what is sent as decoded packets; hands over what the test puts in.
class RecordingPort final : public PacketPort {
 public:
  bool send(std::span<const std::uint8_t> packet) override {
    if (refuses) return false;
    parser.feed(packet, [this](const mav::PacketView& view) {
      ids.push_back(view.message_id);
      source = view.source;
      if (const auto sensor = mav::decode<mv::HilSensor>(view)) sensors.push_back(*sensor);
      if (const auto gps = mav::decode<mv::HilGps>(view)) fixes.push_back(*gps);
    });
    return true;
  }
  void poll(const OnBytes& on_bytes) override {
    for (const auto& bytes : in) on_bytes(bytes, clock);
    in.clear();
  }
  bool wait(base::Duration) override { return !in.empty(); }
  base::RunTime now() const override { return clock; }
  std::string endpoint() const override { return "test"; }

  template <class Message>
  void put(const Message& message) {
    const auto bytes = encoder(message);
    in.emplace_back(bytes.begin(), bytes.end());
  }

  mav::PacketParser parser{mv::table()};
  mav::Encoder encoder{{1, 1}};
  std::vector<std::uint32_t> ids;
  std::vector<mv::HilSensor> sensors;
  std::vector<mv::HilGps> fixes;
  mav::Source source;
  std::deque<std::vector<std::uint8_t>> in;
  base::RunTime clock{std::chrono::seconds(100)};
  bool refuses = false;
};

HilInterfaceParams interface_params() {
  HilInterfaceParams params;
  params.scales = {.u1_max_n = 20, .u2_max_nm = 2, .u3_max_nm = 2, .u4_max_nm = 1};
  params.actuator_timeout = milliseconds(500);
  return params;
}

base::SimTime at_ms(int ms) { return base::SimTime(milliseconds(ms)); }

ImuSample imu_at(int ms) {
  ImuSample sample;
  sample.time = at_ms(ms);
  return sample;
}

GpsSample fix_at(int ms) {
  GpsSample sample;
  sample.time = at_ms(ms);
  return sample;
}

mv::HilControls controls_for(int ms, float throttle = 0.5F) {
  mv::HilControls controls;
  controls.time_usec = static_cast<std::uint64_t>(ms) * 1000;
  controls.throttle = throttle;
  controls.mode = static_cast<decltype(controls.mode)>(128 + 32);
  return controls;
}

std::uint32_t updated(const mv::HilSensor& packet) {
  return static_cast<std::uint32_t>(packet.fields_updated);
}

TEST(HilInterface, FlagsOnlyWhatIsNew) {
  RecordingPort port;
  HilInterface interface(interface_params(), port, nullptr);
  interface.on_imu(imu_at(2));
  interface.on_magnetometer({at_ms(2), {0.2, 0, -0.4}});
  interface.on_barometer({at_ms(2), 95600, 12});
  interface.flush(at_ms(2));
  interface.on_imu(imu_at(4));
  interface.flush(at_ms(4));
  ASSERT_EQ(port.sensors.size(), 2U);
  EXPECT_EQ(updated(port.sensors[0]), 0x1BFFU);
  EXPECT_EQ(updated(port.sensors[1]), 0x003FU);
  EXPECT_FLOAT_EQ(port.sensors[1].abs_pressure, 956);  // repeats the last value, not flagged
  EXPECT_EQ(port.sensors[1].time_usec, 4000U);
}

TEST(HilInterface, SendsNothingWithoutANewSample) {
  RecordingPort port;
  HilInterface interface(interface_params(), port, nullptr);
  interface.flush(at_ms(1));
  interface.flush(at_ms(2));
  EXPECT_EQ(port.ids, std::vector<std::uint32_t>{mv::Heartbeat::kId});
}

TEST(HilInterface, SendsTheFixBeforeTheSensorsOfTheSameMoment) {
  RecordingPort port;
  HilInterface interface(interface_params(), port, nullptr);
  interface.on_imu(imu_at(200));
  interface.on_gps(fix_at(200));
  interface.flush(at_ms(200));
  EXPECT_EQ(port.ids, (std::vector<std::uint32_t>{0, 113, 107}));
  EXPECT_EQ(port.source, (mav::Source{1, 200}));
}

TEST(HilInterface, BeatsOncePerSecond) {
  RecordingPort port;
  HilInterface interface(interface_params(), port, nullptr);
  for (int ms = 1; ms <= 10000; ++ms) interface.flush(at_ms(ms));
  EXPECT_EQ(interface.sent().of(mv::Heartbeat::kId), 11U);  // one at once, then each second
}

TEST(HilInterface, CountsOnlyWhatThePortTook) {
  RecordingPort port;
  HilInterface interface(interface_params(), port, nullptr);
  port.refuses = true;
  interface.on_imu(imu_at(2));
  interface.flush(at_ms(2));
  EXPECT_EQ(interface.sent().of(mv::HilSensor::kId), 0U);
}

TEST(HilInterface, TakesTheNewestCommandOnce) {
  RecordingPort port;
  HilInterface interface(interface_params(), port, nullptr);
  port.put(controls_for(2, 0.25F));
  port.put(controls_for(4, 0.5F));
  interface.receive();
  const auto command = interface.take_command(at_ms(5));
  ASSERT_TRUE(command);
  EXPECT_DOUBLE_EQ(command->values[0], 10);
  EXPECT_FALSE(interface.take_command(at_ms(6)));
  EXPECT_EQ(interface.received().of(mv::HilControls::kId), 2U);
}

TEST(HilInterface, TakesActuatorControlsToo) {
  RecordingPort port;
  HilInterface interface(interface_params(), port, nullptr);
  mv::HilActuatorControls outputs;
  outputs.controls[2] = 0.5F;
  outputs.mode = static_cast<decltype(outputs.mode)>(129);
  port.put(outputs);
  interface.receive();
  const auto command = interface.take_command(at_ms(1));
  ASSERT_TRUE(command);
  EXPECT_EQ(command->kind, MotorCommand::Kind::kMotorOutputs);
  EXPECT_TRUE(command->armed);
}

TEST(HilInterface, StopsTheRotorsWhenTheStreamDies) {
  RecordingPort port;
  HilInterface interface(interface_params(), port, nullptr);
  EXPECT_FALSE(interface.take_command(at_ms(10000)));  // never a stream: nothing to lose
  port.put(controls_for(2));
  interface.receive();
  EXPECT_TRUE(interface.take_command(at_ms(10000))->armed);
  EXPECT_FALSE(interface.take_command(at_ms(10499)));
  const auto stop = interface.take_command(at_ms(10500));
  ASSERT_TRUE(stop);
  EXPECT_FALSE(stop->armed);
  EXPECT_TRUE(stop->values.isZero(0.0));
  EXPECT_FALSE(interface.take_command(at_ms(12000)));  // once
  EXPECT_EQ(interface.actuator_timeouts(), 1U);
}

TEST(HilInterface, WaitsForTheAnswersThatAreDue) {
  RecordingPort port;
  HilInterface interface(interface_params(), port, nullptr);
  // 400 Hz on 500 Hz: floor(t * 400) advances at 4, 6, 8, 10, not at 2, 12, ...
  std::vector<int> due;
  for (int ms = 2; ms <= 20; ms += 2) {
    interface.on_imu(imu_at(ms));
    interface.flush(at_ms(ms));
    if (!interface.answered()) due.push_back(ms);
    port.put(controls_for(ms));
    interface.receive();
    EXPECT_TRUE(interface.answered());
  }
  EXPECT_EQ(due, (std::vector<int>{4, 6, 8, 10, 14, 16, 18, 20}));
}

TEST(HilInterface, AnAnswerToWhatWasNeverSentIsNone) {
  RecordingPort port;
  HilInterface interface(interface_params(), port, nullptr);
  interface.on_imu(imu_at(4));
  interface.flush(at_ms(4));
  port.put(controls_for(900));
  interface.receive();
  EXPECT_FALSE(interface.answered());
}

TEST(HilInterface, KeepsALedgerOfHilPackets) {
  RecordingPort port;
  base::PacketLedger ledger(16);
  HilInterface interface(interface_params(), port, &ledger);
  interface.on_imu(imu_at(2));
  interface.on_gps(fix_at(1));
  interface.flush(at_ms(2));
  port.put(controls_for(2));
  interface.receive();
  ASSERT_EQ(ledger.entries().size(), 3U);  // no heartbeat
  EXPECT_EQ(ledger.entries()[0].message_id, mv::HilGps::kId);
  EXPECT_EQ(ledger.entries()[0].time_usec, 1000U);
  EXPECT_EQ(ledger.entries()[1].message_id, mv::HilSensor::kId);
  EXPECT_EQ(ledger.entries()[2].direction, base::LedgerEntry::Direction::kReceived);
  EXPECT_EQ(ledger.entries()[2].time_usec, 2000U);
  EXPECT_EQ(ledger.entries()[2].at_ns, 100'000'000'000);
}

TEST(HilInterface, CountsDamageAndLoss) {
  RecordingPort port;
  HilInterface interface(interface_params(), port, nullptr);
  port.put(controls_for(2));
  port.put(controls_for(4));
  port.put(controls_for(6));
  port.in[1][20] ^= 0xFF;
  interface.receive();
  EXPECT_EQ(interface.received().of(mv::HilControls::kId), 2U);
  const std::string stats = interface.stats_json();
  EXPECT_NE(stats.find("\"crc_errors\":1"), std::string::npos) << stats;
  EXPECT_NE(stats.find("\"lost_by_sequence\":1"), std::string::npos) << stats;
  EXPECT_NE(stats.find("\"HIL_CONTROLS\":2"), std::string::npos) << stats;
}

/// A plain UDP socket on a free port of the loopback.
class Peer {
 public:
  Peer() : socket_(::socket(AF_INET, SOCK_DGRAM, 0)) {
    sockaddr_in any{};
    any.sin_family = AF_INET;
    any.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    bind(socket_, reinterpret_cast<sockaddr*>(&any), sizeof any);
    socklen_t size = sizeof address_;
    getsockname(socket_, reinterpret_cast<sockaddr*>(&address_), &size);
  }
  ~Peer() { close(socket_); }
  std::string endpoint() const { return "127.0.0.1:" + std::to_string(ntohs(address_.sin_port)); }
  void send_to(const std::string& endpoint, std::span<const std::uint8_t> bytes) {
    sockaddr_in to = address_;
    to.sin_port =
        htons(static_cast<std::uint16_t>(std::stoi(endpoint.substr(endpoint.rfind(':') + 1))));
    sendto(socket_, bytes.data(), bytes.size(), 0, reinterpret_cast<sockaddr*>(&to), sizeof to);
  }
  std::vector<std::uint8_t> receive() {
    pollfd waiting{socket_, POLLIN, 0};
    if (::poll(&waiting, 1, 10000) <= 0) return {};
    std::vector<std::uint8_t> bytes(2048);
    const ssize_t size = recv(socket_, bytes.data(), bytes.size(), 0);
    bytes.resize(static_cast<std::size_t>(std::max<ssize_t>(size, 0)));
    return bytes;
  }

 private:
  int socket_;
  sockaddr_in address_{};
};

base::ConfigNode scalar(const std::string& text) {
  return base::ConfigNode::parse("a: " + text).at("a");
}

constexpr std::array<std::uint8_t, 3> kThree{1, 2, 3};

TEST(UdpPort, SendsAndReceivesWithTheMomentOfArrival) {
  Peer peer;
  UdpPort port(scalar("127.0.0.1:0"), scalar(peer.endpoint()));
  ASSERT_TRUE(port.send(kThree));
  EXPECT_EQ(peer.receive(), (std::vector<std::uint8_t>{1, 2, 3}));

  const base::RunTime before = base::steady_now();
  for (int i = 0; i < 40; ++i) peer.send_to(port.endpoint(), kThree);  // more than one batch
  ASSERT_TRUE(port.wait(kPatience));
  int datagrams = 0;
  constexpr base::Duration kClockReading = milliseconds(5);  // two clocks are read, not one
  port.poll([&](std::span<const std::uint8_t> bytes, base::RunTime at) {
    EXPECT_EQ(bytes.size(), 3U);
    EXPECT_GE(at, before - kClockReading);
    EXPECT_LE(at, base::steady_now());
    ++datagrams;
  });
  EXPECT_EQ(datagrams, 40);
}

TEST(UdpPort, ListensToItsPeerOnly) {
  Peer peer;
  Peer stranger;
  UdpPort port(scalar("127.0.0.1:0"), scalar(peer.endpoint()));
  stranger.send_to(port.endpoint(), kThree);
  ASSERT_TRUE(port.wait(kPatience));
  port.poll([](std::span<const std::uint8_t>, base::RunTime) { ADD_FAILURE() << "a stranger"; });
  EXPECT_NE(port.stats_json().find("\"foreign_datagrams\":1"), std::string::npos);
}

TEST(UdpPort, WithoutARemoteAnswersWhoeverSpeaksFirst) {
  Peer peer;
  UdpPort port(scalar("127.0.0.1:0"), std::nullopt);
  EXPECT_FALSE(port.send(kThree));
  peer.send_to(port.endpoint(), kThree);
  ASSERT_TRUE(port.wait(kPatience));
  port.poll([](std::span<const std::uint8_t>, base::RunTime) {});
  EXPECT_TRUE(port.send(kThree));
  EXPECT_EQ(peer.receive().size(), 3U);
}

TEST(UdpPort, APeerThatIsNotThereCostsNothing) {
  std::string nobody;
  {
    Peer gone;
    nobody = gone.endpoint();
  }
  UdpPort port(scalar("127.0.0.1:0"), scalar(nobody));
  for (int i = 0; i < 10; ++i) EXPECT_TRUE(port.send(kThree));
}

TEST(UdpPort, RefusesWhatIsNoAddress) {
  EXPECT_THROW(UdpPort(scalar("nonsense"), std::nullopt), base::ConfigError);
  EXPECT_THROW(UdpPort(scalar("127.0.0.1:notaport"), std::nullopt), base::ConfigError);
  UdpPort first(scalar("127.0.0.1:0"), std::nullopt);
  EXPECT_THROW(UdpPort(scalar(first.endpoint().substr(4)), std::nullopt), base::ConfigError);
}

TEST(MavlinkInterfacePlugin, CarriesTheSensorsOfOneSecondOverTheBus) {
  test::PluginHarness harness;
  harness.add("imu", "{rate_hz: 500, gyro_stddev_deg_s: 1, accel_stddev_m_s2: 0.05}");
  harness.add("gps",
              "{rate_hz: 5, position_stddev_m: 0.3, velocity_stddev_m_s: 0.1, eph_m: 0.42, "
              "epv_m: 0.3, satellites: 10}");
  harness.add("magnetometer", "{rate_hz: 100, stddev_gauss: 0.004}");
  harness.add("barometer", "{rate_hz: 50, stddev_pa: 1}");
  Plugin& plugin = harness.add("mavlink_interface", "{transport: bus}");
  RecordingPort recorder;
  const auto listening =
      harness.bus.subscribe<WirePacket>("iris0/wire_out", [&](const WirePacket& packet) {
        recorder.send({packet.bytes.data(), packet.size});
      });
  harness.run(std::chrono::seconds(1));

  EXPECT_EQ(recorder.sensors.size(), 500U);
  EXPECT_EQ(recorder.fixes.size(), 5U);
  int magnetic = 0;
  int baric = 0;
  for (const auto& sensor : recorder.sensors) {
    magnetic += (updated(sensor) & kUpdatedMag) == kUpdatedMag;
    baric += (updated(sensor) & kUpdatedBaro) == kUpdatedBaro;
    EXPECT_EQ(updated(sensor) & 0x3FU, 0x3FU);
  }
  EXPECT_EQ(magnetic, 100);
  EXPECT_EQ(baric, 50);
  EXPECT_NEAR(recorder.sensors.back().zacc, -test::kGravity, 0.5);
  EXPECT_NE(plugin.stats_json().find("\"HIL_SENSOR\":500"), std::string::npos);
}

TEST(MavlinkInterfacePlugin, TurnsControlsFromTheBusIntoAMotorCommand) {
  test::PluginHarness harness;
  const auto wire_in = harness.bus.advertise<WirePacket>("iris0/wire_in");
  harness.add("mavlink_interface", "{transport: bus}");
  std::vector<MotorCommand> commands;
  const auto listening = harness.bus.subscribe<MotorCommand>(
      "iris0/motor_command", [&](const MotorCommand& command) { commands.push_back(command); });
  mav::Encoder encoder({1, 1});
  const auto bytes = encoder(controls_for(0, 1.0F));
  WirePacket packet;
  packet.size = bytes.size();
  std::copy(bytes.begin(), bytes.end(), packet.bytes.begin());
  wire_in.publish(packet);
  harness.step();
  ASSERT_EQ(commands.size(), 1U);
  EXPECT_TRUE(commands[0].armed);
  EXPECT_NEAR(commands[0].values[0], 28.2656, 1e-4);  // the vehicle's full scale
}

TEST(MavlinkInterfacePlugin, HoldsLockstepUntilTheAnswerArrivesOverUdp) {
  Peer peer;
  test::PluginHarness harness;
  harness.add("imu", "{rate_hz: 500, gyro_stddev_deg_s: 1, accel_stddev_m_s2: 0.05}");
  Plugin& plugin =
      harness.add("mavlink_interface",
                  "{transport: udp, local: '127.0.0.1:0', remote: '" + peer.endpoint() + "'}");
  ASSERT_NE(harness.context.lockstep_peer, nullptr);
  LockstepPeer& lockstep = *harness.context.lockstep_peer;
  harness.run(milliseconds(3));
  EXPECT_TRUE(lockstep.wait_for_controls(at_ms(3), kPatience));  // 2 ms: no answer is due
  harness.step();
  EXPECT_FALSE(lockstep.wait_for_controls(at_ms(4), milliseconds(1)));

  const std::string stats = plugin.stats_json();
  const std::size_t start = stats.find("udp ") + 4;
  mav::Encoder encoder({1, 1});
  peer.send_to(stats.substr(start, stats.find('"', start) - start), encoder(controls_for(4)));
  EXPECT_TRUE(lockstep.wait_for_controls(at_ms(4), kPatience));
}

}  // namespace
}  // namespace cas::sim
