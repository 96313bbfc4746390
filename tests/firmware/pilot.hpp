// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "casd/station/vehicle_commander.hpp"
#include "mavlink/common/table.hpp"
#include "mavlink_gen/runtime/packet_parser.hpp"

namespace cas::test {

/// Flies a vehicle through casd's commander: arms as soon as it may, takes off, hovers, lands and
/// waits until the vehicle has disarmed itself. Time is the vehicle's.
class Pilot {
 public:
  struct Plan {
    double altitude_m = 5;
    base::Duration hover = std::chrono::seconds(4);
    bool waits_for_position = true;
    bool not_hil = true;  ///< the vehicle's HEARTBEAT does not say HIL
  };
  enum class Stage { kWait, kArm, kTakeoff, kClimb, kHover, kLand, kDescend, kDone, kFailed };

  /// @param to_vehicle  called with each packet during tick(), never inside on_bytes()
  Pilot(const Plan& plan, casd::SendPacket to_vehicle)
      : plan_(plan),
        to_vehicle_(std::move(to_vehicle)),
        commander_({.allow_not_hil = true},
                   [this](std::span<const std::uint8_t> packet, std::span<const casd::Path>) {
                     queue_.emplace_back(packet.begin(), packet.end());
                   }) {}

  void on_bytes(std::span<const std::uint8_t> bytes, base::RunTime now) {
    const auto take = [&](const mav::PacketView& packet) {
      commander_.on_packet(casd::LinkId{0}, packet, now);
    };
    parser_.feed(bytes, take, take);  // also messages of another dialect, as a UDP link of casd
  }
  void tick(base::RunTime now);
  /// From now on it only listens.
  void ask_nothing() {
    commander_.set_commanding(1, false, false);
    stage_ = Stage::kDone;
  }

  Stage stage() const { return stage_; }
  bool ended() const { return stage_ == Stage::kDone || stage_ == Stage::kFailed; }
  /// The height above home at the end of the hover.
  double hover_altitude_m() const { return hover_altitude_m_; }
  const std::string& failure() const { return failure_; }
  /// Its stage and the last refusal, for a failed test.
  std::string story() const {
    return "stage " + std::to_string(static_cast<int>(stage_)) + "; " + failure_ +
           (refusals_.empty() ? "" : "; last refusal: " + refusals_.back().message);
  }
  const std::vector<casd::Outcome>& refusals() const { return refusals_; }
  casd::VehicleCommander& commander() { return commander_; }
  const casd::VehicleState* vehicle() const { return commander_.find(kSystem); }

 private:
  static constexpr std::uint8_t kSystem = 1;
  static constexpr base::Duration kAskAgain = std::chrono::seconds(2);

  void enter(Stage stage, base::RunTime now) {
    stage_ = stage;
    since_ = now;
  }
  /// Ends a command: on to `next`, or the flight has failed.
  casd::Done then(Stage next);

  void step(base::RunTime now);

  Plan plan_;
  casd::SendPacket to_vehicle_;
  std::deque<std::vector<std::uint8_t>> queue_;
  casd::VehicleCommander commander_;
  mav::PacketParser parser_{mavlink::common::table()};
  Stage stage_ = Stage::kWait;
  base::RunTime since_{};
  base::RunTime now_{};
  double hover_altitude_m_ = 0;
  std::string failure_;
  std::vector<casd::Outcome> refusals_;
};

}  // namespace cas::test
