// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "casd/tlog/tlog_packets.hpp"
#include "mavlink/common/all.hpp"
#include "mavlink/common/table.hpp"
#include "mavlink_gen/runtime/codec.hpp"
#include "tests/firmware/shipped_text.hpp"
#include "tests/support/child_process.hpp"
#include "tests/support/free_port.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/support/udp_peer.hpp"
#include "tests/support/vehicle_summary.hpp"
#include "tests/support/wait_until.hpp"

namespace cas::test {

namespace mv = mavlink::common;

inline constexpr mav::Source kStation{255, 190};
inline constexpr mav::Source kCasd{254, 190};
inline constexpr mav::Source kVehicle{1, 1};
/// A whole flight on a busy machine, under a sanitizer.
inline constexpr base::Duration kFlightPatience = std::chrono::minutes(3);

/// A flight by hils of the scripted PX4 in software: hilsim, casd, hils and the firmware as
/// programs, as fast as they can, and this process as a ground station.
class SitlFlight : public testing::Test {
 protected:
  static constexpr const char* kOneFlight = R"(  - takeoff: {altitude_m: 2, timeout_s: 200}
  - hold: {duration_s: 1, measure: true}
  - land: {timeout_s: 100}
  - disarm: {timeout_s: 50}
)";

  /// @param word  behaviour of the scripted PX4, and further words for it
  /// @param more  further keys of the scenario
  /// @param steps  after first_step_
  void start(const std::string& word, const std::string& more = "",
             const std::string& steps = kOneFlight) {
    const auto scenario = write_scenario(word, more, steps);
    hils_.emplace(std::vector<std::string>{binary_dir() + "/bin/hils", "run", scenario.string(),
                                           "--out", folder_ / "out"});
    station_.set_remote(port_of("127.0.0.1:" + ports_.ground_station));
  }

  /// The scenario's file, with those of world and topology beside it.
  std::filesystem::path write_scenario(const std::string& word, const std::string& more = "",
                                       const std::string& steps = kOneFlight) {
    ports_.ground_station = std::to_string(free_port());
    folder_.write("world.yaml",
                  with_whole_paths(replaced(px4_sitl_world(ports_), "\nspeed: 1\n", pace_)));
    folder_.write("topology.yaml", with_whole_paths(px4_sitl_topology(ports_)));
    return folder_.write("scenario.yaml", R"(schema: 1
name: disarm
world: world.yaml
topology: topology.yaml
not_hil: true
steps:
)" + first_step_ + steps + more + R"(
firmware:
  hint: a hint of the scenario
)" + (cwd_.empty() ? "" : "  cwd: '" + cwd_ + "'\n") +
                                              "  command: " + command_with(word) + "\n");
  }

  std::string command_with(const std::string& word) const {
    if (!command_.empty()) return command_;
    return "['" + binary_dir() + "/tests/scripted_firmware', px4-sitl, " + ports_.arguments() +
           ", " + word + "]";
  }

  /// A file of the results.
  std::string left(const std::string& file) const { return content(folder_.path() / "out" / file); }
  nlohmann::json summary() const { return vehicle_summary(folder_.path() / "out"); }

  /// Goes on until hils has ended; sends HEARTBEATs and passes packets from casd on.
  std::optional<int> fly(const std::function<void(const mav::PacketView&)>& on_packet = {}) {
    std::optional<int> code;
    base::RunTime beat{};
    wait_until(
        [&] {
          if (base::steady_now() > beat) {
            mv::Heartbeat heartbeat;
            heartbeat.type = mv::MavType::kGcs;
            heartbeat.autopilot = mv::MavAutopilot::kInvalid;
            say(heartbeat);
            beat = base::steady_now() + std::chrono::milliseconds(200);
          }
          PacketStream heard;
          station_.read(heard);
          for (const PacketStream::Packet& packet : heard.packets()) {
            if (on_packet) on_packet(packet.view());
          }
          code = hils_->wait_exit(base::Duration::zero());
          return code.has_value();
        },
        kFlightPatience);
    return code;
  }

  template <class Message>
  void say(const Message& message) {
    station_.send(as_station_(message));
  }

  /// How often casd had it armed, by the flight log; repetitions do not count.
  int armings() const {
    int count = 0;
    casd::for_each_tlog_packet(folder_.path() / "out/flight.tlog", mv::table(),
                               [&](std::uint64_t, const mav::PacketView& packet) {
                                 const auto command = mav::decode<mv::CommandLong>(packet);
                                 if (!command || packet.source != kCasd) return;
                                 count += command->command == mv::MavCmd::kComponentArmDisarm &&
                                          command->param1 == 1 && command->confirmation == 0;
                               });
    return count;
  }

  bool says(const std::string& words) const {
    return hils_->output().find(words) != std::string::npos;
  }
  std::string output() const { return hils_->output(); }

  /// Of the world: as fast as the programs can. A stream of setpoints needs a pace: a busy machine
  /// is late by the wall clock, and PX4 waits for a second of its own.
  std::string pace_ = "\n";
  std::string first_step_ = "  - arm: {timeout_s: 100}\n";
  std::string command_;  ///< of another firmware than the scripted one
  std::string cwd_;      ///< of the firmware
  TemporaryFolder folder_;
  Px4SitlPorts ports_;
  UdpPeer station_;
  mav::Encoder as_station_{kStation};
  std::optional<ChildProcess> hils_;
};

}  // namespace cas::test
