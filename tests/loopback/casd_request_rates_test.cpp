// SPDX-License-Identifier: BSD-3-Clause
// Message rates that the real casd requests from a vehicle, by `request_rates` of its link.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <functional>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "tests/loopback/running_casd.hpp"
#include "tests/loopback/udp_autopilot.hpp"
#include "tests/support/ended_with.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::test {
namespace {

using namespace mavlink::common;

constexpr base::Duration kSilence = std::chrono::milliseconds(3500);  // more than the 3 s of casd

class CasdRequestRates : public testing::Test {
 protected:
  void start(const std::string& rates) {
    const std::string topology = folder.write(
        "topology.yaml",
        "schema: 1\ncommand_port: {port: 0, loopback_without_token: true}\n"
        "links:\n  - {name: net, type: udp_server, local: \"127.0.0.1:0\", request_rates: " +
            rates + "}\n");
    casd.emplace(std::vector<std::string>{kCasdProgram, topology});
    vehicle.socket.set_remote(casd->port("net"));
  }
  /// How often the interval of a message was asked for, in the order of first requests.
  std::size_t asked(std::uint32_t id) const {
    return static_cast<std::size_t>(
        std::count_if(vehicle.commands.begin(), vehicle.commands.end(), [&](const auto& command) {
          return command.command == MavCmd::kSetMessageInterval &&
                 command.param1 == static_cast<float>(id);
        }));
  }
  float period_us(std::uint32_t id) const {
    for (const CommandLong& command : vehicle.commands) {
      const bool is = command.command == MavCmd::kSetMessageInterval &&
                      command.param1 == static_cast<float>(id);
      if (is) return command.param2;
    }
    return 0;
  }
  /// ATTITUDE tells the vehicle's clock.
  void tell_time(std::uint32_t time_boot_ms) {
    Attitude attitude;
    attitude.time_boot_ms = time_boot_ms;
    vehicle.socket.send(vehicle.encoder(attitude));
  }

  TemporaryFolder folder;
  std::optional<RunningCasd> casd;
  UdpAutopilot vehicle{MavAutopilot::kPx4};
};

TEST_F(CasdRequestRates, AreAskedForOnceAndAgainAfterARestart) {
  start("{ATTITUDE: 50, VFR_HUD: 0}");
  std::uint32_t time_ms = 60'000;
  const auto tell = [&] { tell_time(time_ms += 10); };
  ASSERT_TRUE(speaks_until(
      vehicle, [&] { return asked(VfrHud::kId) > 0; }, tell));
  EXPECT_EQ(period_us(Attitude::kId), 20'000);
  EXPECT_EQ(period_us(VfrHud::kId), -1);
  // A restart is one once it is no jump of the clock: 3 s after it was last asked.
  const base::RunTime later = base::steady_now() + std::chrono::seconds(4);
  ASSERT_TRUE(speaks_until(
      vehicle, [&] { return base::steady_now() > later; }, tell));
  EXPECT_EQ(asked(Attitude::kId), 1U);
  EXPECT_EQ(asked(VfrHud::kId), 1U);
  time_ms = 100;
  ASSERT_TRUE(speaks_until(
      vehicle, [&] { return asked(VfrHud::kId) > 1; }, tell));
  EXPECT_EQ(asked(Attitude::kId), 2U);
}

TEST_F(CasdRequestRates, AreRepeatedUntilAcknowledgedAndARefusalIsTold) {
  start("{ATTITUDE: 50}");
  vehicle.answers = false;
  ASSERT_TRUE(speaks_until(vehicle, [&] { return asked(Attitude::kId) == 2; }));
  vehicle.answers = true;
  vehicle.result = MavResult::kDenied;
  EXPECT_TRUE(speaks_until(vehicle, [&] {
    return casd->output().find("does not send message 30 at 50 Hz") != std::string::npos;
  })) << casd->output();
  EXPECT_EQ(asked(Attitude::kId), 3U);
}

TEST_F(CasdRequestRates, TakeThePlaceOfWhatAnArduPilotIsAskedForAnyway) {
  vehicle.kind = MavAutopilot::kArdupilotmega;
  start("{ATTITUDE: 50}");
  ASSERT_TRUE(speaks_until(vehicle, [&] { return asked(Attitude::kId) > 0; }));
  EXPECT_EQ(period_us(Attitude::kId), 20'000);
  EXPECT_EQ(asked(Attitude::kId), 1U);
  EXPECT_EQ(asked(SysStatus::kId), 1U);
}

TEST_F(CasdRequestRates, AreAskedForAgainOfAVehicleThatWasSilentForThreeSeconds) {
  start("{ATTITUDE: 50}");
  ASSERT_TRUE(speaks_until(vehicle, [&] { return asked(Attitude::kId) == 1; }));
  const base::RunTime fell_silent = base::steady_now();
  ASSERT_TRUE(wait_until([&] { return base::steady_now() > fell_silent + kSilence; }));
  EXPECT_EQ(asked(Attitude::kId), 1U);
  EXPECT_TRUE(speaks_until(vehicle, [&] { return asked(Attitude::kId) == 2; }));
}

// It forgets its streams, and no message with its clock tells of the restart.
TEST_F(CasdRequestRates, AreAskedForAgainOfAnArduPilotThatOnlyBeatsAnyMore) {
  vehicle.kind = MavAutopilot::kArdupilotmega;
  start("{VFR_HUD: 5}");
  std::uint32_t time_ms = 60'000;
  const auto tell = [&] { tell_time(time_ms += 10); };
  ASSERT_TRUE(speaks_until(
      vehicle, [&] { return asked(VfrHud::kId) == 1; }, tell));
  const base::RunTime asked_at = base::steady_now();
  ASSERT_TRUE(speaks_until(
      vehicle, [&] { return base::steady_now() > asked_at + kSilence; }, tell));
  EXPECT_EQ(asked(VfrHud::kId), 1U) << "while it tells of itself";
  EXPECT_TRUE(speaks_until(vehicle, [&] { return asked(VfrHud::kId) == 2; }));
  EXPECT_EQ(asked(Attitude::kId), 2U) << "what it is asked for anyway, too";
}

/// fcu_emulator behind the real casd, and a ground station that sees the resulting rates.
class CasdRequestRatesOfTheEmulator : public testing::Test {
 protected:
  CasdRequestRatesOfTheEmulator() {
    const std::string device = (folder / "fcu0").string();
    const std::string controller =
        folder.write("fcu.yaml", "schema: 1\nvehicle: " + source_dir() +
                                     "/config/vehicles/iris_paper.yaml\nline: {preset: ideal}\n");
    fcu.emplace(
        std::vector<std::string>{binary_dir() + "/bin/fcu_emulator", controller, "--link", device});
    if (!fcu->wait_ready()) throw std::runtime_error(fcu->output());
    const std::string topology =
        folder.write("casd.yaml",
                     "schema: 1\ncommand_port: {port: 0, loopback_without_token: true}\nlinks:\n"
                     "  - {name: fcu, type: serial, device: '" +
                         device +
                         "', baud: 0, request_rates: {ATTITUDE: 10, SYSTEM_TIME: 20}}\n"
                         "  - {name: gcs, type: udp_server, local: '127.0.0.1:0'}\n");
    casd.emplace(std::vector<std::string>{kCasdProgram, topology});
    station.set_remote(casd->port("gcs"));
  }

  /// Notes the vehicle's clock in each message of these two kinds.
  template <class Message>
  void note(const mav::PacketView& packet, std::vector<std::uint32_t>& times) {
    const auto message = mav::decode<Message>(packet);
    if (!message) return;
    if (!times.empty() && message->time_boot_ms < times.back()) {
      rebooted = true;
      attitudes.clear();
      system_times.clear();
    }
    times.push_back(message->time_boot_ms);
  }
  bool watch_until(const std::function<bool()>& condition) {
    return wait_until([&] {
      if (base::steady_now() >= next_beat) {
        next_beat = base::steady_now() + std::chrono::milliseconds(500);
        station.send(
            encoder(Heartbeat{.type = MavType::kGcs, .autopilot = MavAutopilot::kInvalid}));
      }
      station.read(heard);
      for (; !heard.packets().empty(); heard.packets().pop_front()) {
        const mav::PacketView packet = heard.packets().front().view();
        note<Attitude>(packet, attitudes);
        note<SystemTime>(packet, system_times);
      }
      return condition();
    });
  }
  /// The mean time between the newest of them, by the vehicle's clock; 0: there are too few.
  static double period_ms(const std::vector<std::uint32_t>& times) {
    constexpr std::size_t kSteps = 10;
    if (times.size() <= kSteps) return 0;
    return static_cast<double>(times.back() - times[times.size() - 1 - kSteps]) / kSteps;
  }
  bool at_the_rates() const {
    const double attitude = period_ms(attitudes);
    const double time = period_ms(system_times);
    return std::abs(attitude - 100) <= 2 && std::abs(time - 50) <= 2;
  }

  TemporaryFolder folder;
  std::optional<ChildProcess> fcu;
  std::optional<RunningCasd> casd;
  UdpPeer station;
  mav::Encoder encoder{{255, 190}};
  PacketStream heard;
  base::RunTime next_beat{};
  std::vector<std::uint32_t> attitudes;
  std::vector<std::uint32_t> system_times;
  bool rebooted = false;
};

TEST_F(CasdRequestRatesOfTheEmulator, ComeAgainAfterAReboot) {
  ASSERT_TRUE(watch_until([&] { return at_the_rates(); }))
      << period_ms(attitudes) << " " << period_ms(system_times) << casd->output();
  CommandLong reboot{.target_system = 1,
                     .target_component = 1,
                     .command = MavCmd::kPreflightRebootShutdown,
                     .param1 = 1};
  station.send(encoder(reboot));
  ASSERT_TRUE(watch_until([&] { return rebooted; })) << fcu->output();
  EXPECT_TRUE(watch_until([&] { return at_the_rates(); }))
      << period_ms(attitudes) << " " << period_ms(system_times) << casd->output();
}

TEST_F(CasdRequestRates, OfAMessageThatIsNoneAreRefusedWithTheirPlace) {
  const std::string topology =
      folder.write("t.yaml",
                   "schema: 1\nlinks:\n  - {name: a, type: udp, local: \"127.0.0.1:0\",\n"
                   "     request_rates: {ATITUDE: 50}}\n");
  EXPECT_THAT(ChildProcess({binary_dir() + "/bin/casd", "--check", topology}).end(),
              EndedWith(78, "t.yaml:4: links[0].request_rates", "ATITUDE"));
}

}  // namespace
}  // namespace cas::test
