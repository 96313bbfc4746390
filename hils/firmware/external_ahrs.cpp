// SPDX-License-Identifier: BSD-3-Clause
#include "hils/firmware/external_ahrs.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <functional>
#include <nlohmann/json.hpp>
#include <vector>

#include "base/angles.hpp"
#include "hils/flight/flight_plan.hpp"
#include "mavlink/common/enums.hpp"

namespace cas::hils {
namespace {

using base::rpc::Json;

/// All in real time. The driver repeats a line every 0.5 s; its position takes some 40 s.
constexpr base::Duration kAskPatience = std::chrono::seconds(30);
constexpr base::Duration kLevelPatience = std::chrono::seconds(60);
constexpr base::Duration kHeadingPatience = std::chrono::seconds(120);
constexpr base::Duration kBetweenTries = std::chrono::seconds(2);

constexpr int kCalibrate = static_cast<int>(mavlink::common::MavCmd::kPreflightCalibration);
constexpr int kFixedMagCalYaw = 42006;  // MAV_CMD_FIXED_MAG_CAL_YAW: our dialect has no word for it

class AhrsPreparation {
 public:
  AhrsPreparation(FlightDeck& deck, AskedVehicle vehicle, const std::string& name)
      : deck_(deck), vehicle_(vehicle), name_(name) {}

  std::optional<std::string> run() {
    if (deck_.bench.is_board()) {
      if (auto why = restart_board()) return why;
    }
    if (auto why = wait_for_driver()) return why;
    if (auto why = calibrate_level()) return why;
    if (auto why = see_our_motion()) return why;
    return calibrate_compass();
  }

 private:
  /// The driver asks for its packets once, after the board's start: before this run's hilsim.
  std::optional<std::string> restart_board() {
    if (vehicle_report(deck_.casd, vehicle_).armed)
      return "the board is armed: it is not restarted";
    try {
      deck_.casd.call("vehicle.reboot", about(vehicle_, {{"not_hil", true}}), kCallPatience);
      return std::nullopt;
    } catch (const base::rpc::CallError& error) {
      return std::string("the board was not restarted: ") + error.what();
    }
  }

  std::optional<std::string> wait_for_driver() {
    const base::RunTime deadline = base::steady_now() + kAskPatience;
    for (;;) {
      const Json unit = external_ahrs_unit(deck_, name_);
      if (unit.value("running", false)) return std::nullopt;
      if (base::steady_now() > deadline) return why_silent(unit);
      deck_.supervisor.wait(FlightPlan::kLookPeriod);
    }
  }

  static std::string why_silent(const Json& unit) {
    const auto asked = unit.value("asked", std::vector<std::string>{});
    const std::string line = unit.value("endpoint", "");
    if (asked.empty()) {
      return fmt::format(
          "the board asks for no sensors on {}: EAHRS_TYPE 1, SERIALn_PROTOCOL 36 and "
          "SERIALn_BAUD of the port that the line leads to, and a restart",
          line);
    }
    return fmt::format("the board has not finished its questions on {}: {}", line,
                       fmt::join(asked, " | "));
  }

  /// Nothing tells a board on a desk from a simulated one at rest. So the simulated rates about the
  /// forward axis are off by 3 degrees a second for a second, and back: the attitude that the board
  /// reports must go with them.
  std::optional<std::string> see_our_motion() {
    constexpr double kRate_deg_s = 3;
    constexpr double kLeastTurn_deg = 1.5;
    const double before_rad = vehicle_report(deck_.casd, vehicle_).roll_rad;
    double turned_deg = 0;
    turn(kRate_deg_s, [&] {
      const double roll_rad = vehicle_report(deck_.casd, vehicle_).roll_rad;
      turned_deg = std::max(turned_deg, base::degrees(roll_rad - before_rad));
    });
    turn(-kRate_deg_s, [] {});
    if (turned_deg >= kLeastTurn_deg) return std::nullopt;
    return fmt::format(
        "the simulated rates turned the vehicle by {:g} degrees, and the attitude that the board "
        "reports by {:.1f}: it does not fly by these sensors, and is not armed (AHRS_EKF_TYPE 3, "
        "INS_ENABLE_MASK 1)",
        kRate_deg_s, turned_deg);
  }

  /// For a second; `look` is called meanwhile, and for a moment longer.
  void turn(double rate_deg_s, const std::function<void()>& look) {
    constexpr base::Duration kLook = std::chrono::milliseconds(50);
    constexpr base::Duration kLasts = std::chrono::milliseconds(1300);
    const Json fault{{"name", kIdentification},
                     {"for_s", 1},
                     {"bias", {{"sensor", "imu"}, {"angular_rate_deg_s", {rate_deg_s, 0, 0}}}}};
    deck_.simulator.client().call("sim.fault", {{"vehicle", name_}, {"fault", fault}});
    for (const base::RunTime end = base::steady_now() + kLasts; base::steady_now() < end;) {
      look();
      deck_.supervisor.wait(kLook);
    }
  }

  /// ArduPilot answers while it calibrates that it cannot calibrate, so its offsets tell: they are
  /// zero until it has. It takes no second calibration within 5 s of its clock.
  std::optional<std::string> calibrate_level() {
    constexpr double kSimple = 4;  // of parameter 5: the vehicle stands level, and is not turned
    constexpr base::Duration kTakes = std::chrono::seconds(3);
    const base::RunTime deadline = base::steady_now() + kLevelPatience;
    std::optional<std::string> refusal;
    while (!has_level_offsets()) {
      if (base::steady_now() > deadline) {
        return fmt::format("the simple calibration of the accelerometers did not succeed: {}",
                           refusal.value_or("their offsets are zero"));
      }
      refusal = command(kCalibrate, {0, 0, 0, 0, kSimple, 0, 0});
      deck_.supervisor.wait(kTakes);
      if (has_level_offsets()) return std::nullopt;
      deck_.supervisor.wait(kTakes);
    }
    return std::nullopt;
  }

  bool has_level_offsets() {
    return std::ranges::any_of(std::array{"INS_ACCOFFS_X", "INS_ACCOFFS_Y", "INS_ACCOFFS_Z"},
                               [this](const char* name) { return parameter(name) != 0; });
  }

  /// Zero for one that it does not tell.
  double parameter(const char* name) {
    try {
      return deck_.casd.call("param.get", about(vehicle_, {{"name", name}})).value("value", 0.0);
    } catch (const base::rpc::CallError&) {
      return 0;
    }
  }

  /// Calibrates the compass by its heading; refused until the estimator knows where it is.
  std::optional<std::string> calibrate_compass() {
    const base::RunTime deadline = base::steady_now() + kHeadingPatience;
    for (;;) {
      const auto refusal = command(kFixedMagCalYaw, {heading_deg(), 0, 0, 0, 0, 0, 0});
      if (!refusal) return std::nullopt;
      if (base::steady_now() > deadline) {
        return fmt::format("the compass was not calibrated by its heading within {:.0f} s: {}",
                           base::to_seconds(kHeadingPatience), *refusal);
      }
      deck_.supervisor.wait(kBetweenTries);
    }
  }

  /// @return why it was not accepted
  std::optional<std::string> command(int which, const std::vector<double>& params) {
    try {
      deck_.casd.call("vehicle.command", about(vehicle_, {{"command", which}, {"params", params}}),
                      kCallPatience);
      return std::nullopt;
    } catch (const base::rpc::CallError& error) {
      return error.what();
    }
  }

  /// True heading, from 0 to 360.
  double heading_deg() {
    deck_.simulator.look();
    const double yaw_deg = base::degrees(deck_.simulator.status().truth.front().rpy_rad.z());
    return yaw_deg < 0 ? yaw_deg + 360 : yaw_deg;
  }

  static constexpr base::Duration kCallPatience = std::chrono::seconds(10);

  FlightDeck& deck_;
  AskedVehicle vehicle_;
  std::string name_;
};

}  // namespace

Json external_ahrs_unit(FlightDeck& deck, const std::string& name) {
  return deck.simulator.client()
      .call("sim.stats", Json::object())
      .value("plugins", Json::object())
      .value("external_ahrs@" + name, Json::object());
}

std::optional<std::string> prepare_external_ahrs(FlightDeck& deck, AskedVehicle vehicle,
                                                 const std::string& name) {
  return AhrsPreparation(deck, vehicle, name).run();
}

void warn_of_live_outputs() {
  const bool terminal = ::isatty(STDERR_FILENO) == 1;
  fmt::print(stderr,
             "{}hils: THE OUTPUTS OF THIS AUTOPILOT ARE LIVE: ArduPilot has no HIL mode. No motor, "
             "ESC or servo may be connected.{}\n",
             terminal ? "\x1b[1;31m" : "", terminal ? "\x1b[0m" : "");
}

}  // namespace cas::hils
