// SPDX-License-Identifier: BSD-3-Clause
#include "hils/firmware/firmware_pilot.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>

#include "base/rpc/client.hpp"
#include "hils/firmware/disarming.hpp"
#include "hils/programs/pilot_calls.hpp"
#include "hils/programs/progress.hpp"
#include "mavlink/common/autopilot_version.hpp"
#include "mavlink/common/enums.hpp"

namespace cas::hils {
namespace {

using base::rpc::Json;

constexpr base::Duration kPollPeriod = std::chrono::milliseconds(50);
/// All in real time.
constexpr base::Duration kVersionPatience = std::chrono::seconds(20);
constexpr base::Duration kAskAgain = std::chrono::seconds(3);
constexpr base::Duration kSilencePatience = std::chrono::seconds(30);
/// What a vehicle says of its disarming comes with the HEARTBEAT that shows it.
constexpr base::Duration kWordsPatience = std::chrono::seconds(1);
/// PX4 disarms 2 s after it has noticed a landing (v1.12.0, v1.16.1), ArduCopter 4.5.6 sooner.
constexpr FirmwareHabits kHabits{.arms_early = true, .disarms_itself = std::chrono::seconds(5)};

std::int64_t microseconds(base::SimTime t) {
  return std::chrono::duration_cast<std::chrono::microseconds>(t.time_since_epoch()).count();
}

std::int64_t log_clock_us() {
  return std::chrono::duration_cast<std::chrono::microseconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

/// Gives the commands of the plan and looks at the true position.
class FirmwarePilot {
 public:
  FirmwarePilot(const FirmwareScenario& scenario, const FirmwarePlaces& places,
                Supervisor& supervisor)
      : scenario_(scenario),
        supervisor_(supervisor),
        simulator_("unix:" + places.simulator_control().string()),
        casd_("unix:" + places.command_port.string()),
        plan_(scenario.steps, 0, kHabits) {}

  FirmwareFigures fly() {
    if (!is_heard() || !is_of_age()) return figures_;
    while (!plan_.done() && plan_.failure().empty()) {
      const base::SimTime now = look();
      const VehicleReport vehicle = relative_report();
      note_arming(now, vehicle);
      if (figures_.version.empty()) figures_.version = vehicle.firmware;
      plan_.fail(silence_fault(vehicle));
      if (!plan_.failure().empty()) break;
      const std::optional<FlightStep> command = plan_.update(now, vehicle);
      tell_phase();
      measure();
      progress_.show(now, plan_, vehicle, pace_words(figures_.real_time_factor));
      if (command) {
        give(*command);
      } else {
        supervisor_.wait(kPollPeriod);
      }
    }
    tell_phase();
    figures_.under_way = plan_.under_way(look());
    figures_.stages = plan_.stages();
    figures_.flight_failure = plan_.failure();
    if (plan_.failure().starts_with(kDisarmedDuring)) {
      figures_.flight_failure += hands_words(outside_hands());
    }
    add_losses(casd_.call("link.list", Json::object()), figures_);
    figures_.messages = casd_.call("message.list", Json::object()).dump();
    figures_.hops = casd_.call("link.latency", Json::object()).dump();
    return figures_;
  }

 private:
  /// Waits for the firmware's first HEARTBEAT in real time: until the firmware is there, the
  /// simulator's time runs at its own speed and says nothing of how long the firmware takes.
  bool is_heard() {
    const base::Duration patience = scenario_.steps.front().timeout;
    const base::RunTime deadline = base::steady_now() + patience;
    while (!vehicle_report(casd_).heard) {
      if (base::steady_now() > deadline) {
        figures_.flight_failure = fmt::format(
            "the firmware was not heard within {:.0f} s of real time; run/firmware.log "
            "in the results has what it says",
            base::to_seconds(patience));
        return false;
      }
      supervisor_.wait(kPollPeriod);
    }
    figures_.system = casd_.call("vehicle.state", Json::object()).value("system", figures_.system);
    return true;
  }

  void note_arming(base::SimTime now, const VehicleReport& vehicle) {
    if (vehicle.armed) disarmed_at_.reset();
    if (vehicle.armed && !armed_before_) gave_disarm_ = false;  // somebody has armed it since
    armed_before_ = vehicle.armed;
    if (vehicle.armed && !was_armed_) armed_at_ = now;
    if (was_armed_ && seen_armed_ && !vehicle.armed && !disarmed_at_) disarmed_at_ = now;
    was_armed_ = was_armed_ || vehicle.armed;
    seen_armed_ = seen_armed_ || vehicle.armed;
  }

  /// Whether a disarm step is over since the newest arming, and it is known that hils disarmed the
  /// vehicle, or that it did so itself after landing.
  bool has_ended_flight() {
    const auto since = std::span(plan_.stages()).subspan(stages_when_armed_);
    const auto disarms = [](const Stage& stage) { return stage.step.kind == StepKind::kDisarm; };
    return std::ranges::any_of(since, disarms) && is_own_end(gave_disarm_, disarm_words());
  }

  /// The next arming is as the first one.
  void begin_next_flight() {
    was_armed_ = seen_armed_ = false;
    armed_again_ = 0;
    disarmed_at_.reset();
    highest_m_ = 0;
  }

  void give(const FlightStep& command) {
    if (command.kind == StepKind::kArm && was_armed_ && has_ended_flight()) begin_next_flight();
    const bool again = command.kind == StepKind::kArm && was_armed_;
    if (command.kind == StepKind::kArm) {
      plan_.fail(again ? rearm_fault(disarming()) : arm_fault(outside_hands()));
      if (!plan_.failure().empty()) return;
    }
    const std::string refusal =
        hils::give(casd_, command, scenario_.not_hil, std::nullopt, &own_calls_, acts_so_far_);
    const base::SimTime now = look();
    plan_.on_outcome(now, refusal);
    if (command.kind == StepKind::kDisarm && refusal.empty()) gave_disarm_ = true;
    if (command.kind != StepKind::kArm) return;
    // A vehicle that was stopped at its board refuses: asking on and on would start it in the
    // moment in which somebody lets it go.
    if (again && !refusal.empty()) plan_.fail("the vehicle was disarmed, and refuses: " + refusal);
    if (!refusal.empty()) return;
    if (again) ++armed_again_;
    was_armed_ = true;
    seen_armed_ = false;
    armed_at_ = now;
    armed_wall_ = base::steady_now();
    disarmed_at_.reset();
    gave_disarm_ = false;
    stages_when_armed_ = plan_.stages().size();
  }

  /// What comes later than this look keeps casd from arming.
  OutsideHands outside_hands() {
    OutsideHands hands = hils::outside_hands(casd_, own_calls_);
    acts_so_far_ = hands.acts_so_far;
    return hands;
  }

  Disarming disarming() {
    Disarming all{.words = disarm_words(), .highest_m = highest_m_, .armed_again = armed_again_};
    all.autopilot = vehicle_report(casd_).autopilot;
    if (disarmed_at_) all.armed_s = base::to_seconds(*disarmed_at_ - armed_at_);
    if (all.autopilot == "ArduPilot") all.delay_s = parameter("DISARM_DELAY");
    all.hands = outside_hands();  // last: the rest takes its time
    return all;
  }

  /// What the vehicle has said of its disarming since it was armed; waits for it.
  std::string disarm_words() {
    for (const base::RunTime deadline = base::steady_now() + kWordsPatience;;) {
      const VehicleReport vehicle = vehicle_report(casd_);
      const double armed_ago_s = base::to_seconds(base::steady_now() - armed_wall_);
      if (!vehicle.disarm_words.empty() && vehicle.disarm_words_age_s < armed_ago_s) {
        return vehicle.disarm_words;
      }
      if (base::steady_now() > deadline) return {};
      supervisor_.wait(kPollPeriod);
    }
  }

  std::optional<double> parameter(const char* name) {
    try {
      return casd_.call("param.get", {{"name", name}}).at("value").get<double>();
    } catch (const base::rpc::CallError&) {
      return std::nullopt;  // it has none of this name, or does not answer
    }
  }

  /// Waits until the firmware has told the version that the scenario wants, and asks for it now and
  /// then: what casd asked upon the first HEARTBEAT may have come too early.
  bool is_of_age() {
    const base::RunTime deadline = base::steady_now() + kVersionPatience;
    for (base::RunTime ask_at = base::steady_now() + kAskAgain;;) {
      figures_.version = vehicle_report(casd_).firmware;
      const bool wanted = !scenario_.firmware.least_version.empty();
      if (!wanted || !figures_.version.empty() || base::steady_now() > deadline) break;
      if (base::steady_now() > ask_at) {
        ask_for_version();
        ask_at = base::steady_now() + kAskAgain;
      }
      supervisor_.wait(kPollPeriod);
    }
    figures_.flight_failure = version_fault(scenario_.firmware, figures_.version);
    return figures_.flight_failure.empty();
  }

  /// A refusal means that it has none to tell, or not yet.
  void ask_for_version() {
    const Json params{{"command", static_cast<int>(mavlink::common::MavCmd::kRequestMessage)},
                      {"params", {mavlink::common::AutopilotVersion::kId}}};
    own_calls_.emplace_back("vehicle.command", params.dump());
    try {
      casd_.call("vehicle.command", params);
    } catch (const base::rpc::CallError&) {
    }
  }

  base::SimTime look() {
    const Json status = simulator_.call("sim.status", Json::object());
    const Json& p = status.at("vehicles").at(0).at("p_W");
    p_W_ = {p.at(0).get<double>(), p.at(1).get<double>(), p.at(2).get<double>()};
    if (!ground_m_) ground_m_ = p_W_.z();
    highest_m_ = std::max(highest_m_, p_W_.z() - *ground_m_);
    figures_.real_time_factor = status.value("real_time_factor", 0.0);
    figures_.simulated_s = status.at("time_s").get<double>();
    const base::SimTime now(base::from_seconds(figures_.simulated_s));
    figures_.log_clock.add(log_clock_us(), microseconds(now));
    return now;
  }

  /// The plan counts from where the vehicle was armed; a stock estimator's origin may be a little
  /// off that place.
  VehicleReport relative_report() {
    VehicleReport vehicle = vehicle_report(casd_);
    const FlightStep* step = plan_.current();
    const bool on_pad = step != nullptr && !vehicle.armed && step->kind == StepKind::kTakeoff;
    if (on_pad || (step != nullptr && step->kind == StepKind::kArm)) armed_at_N_ = vehicle.p_N;
    vehicle.p_N -= armed_at_N_;
    return vehicle;
  }

  void measure() {
    const FlightStep* step = plan_.current();
    if (step != nullptr && step->kind == StepKind::kTakeoff) altitude_m_ = step->altitude_m;
    measure_rates(step != nullptr && step->measure);
    if (step == nullptr || !step->measure) return;
    if (figures_.looks == 0) hold_begin_W_ = p_W_;
    ++figures_.looks;
    height_sum_m_ += p_W_.z() - *ground_m_;
    figures_.height_error_m = std::abs(height_sum_m_ / figures_.looks - altitude_m_);
    figures_.drift_m = std::max(figures_.drift_m, (p_W_ - hold_begin_W_).head<2>().norm());
  }

  /// The simulator's fault scripts ask for it.
  void tell_phase() {
    if (plan_.phase() == phase_) return;
    phase_ = plan_.phase();
    simulator_.call("sim.phase", {{"name", phase_}});
  }

  /// How many of each message the vehicle has sent, on the link that has most of them.
  std::map<std::string, double> counts() {
    std::map<std::string, double> all;
    for (const Json& row : casd_.call("message.list", Json::object())) {
      if (row.value("direction", "") != "rx" || row.value("system", 0) != figures_.system) continue;
      double& count = all[row.value("name", "")];
      count = std::max(count, row.value("count", 0.0));
    }
    return all;
  }

  /// From one end of the measured hold to the other.
  void measure_rates(bool holding) {
    if (holding == holding_) return;
    holding_ = holding;
    const std::map<std::string, double> now = counts();
    if (holding) {
      counts_before_ = now;
      hold_begin_s_ = figures_.simulated_s;
      return;
    }
    const double held_s = figures_.simulated_s - hold_begin_s_;
    if (!(held_s > 0)) return;
    for (const auto& [name, count] : now) {
      const auto before = counts_before_.find(name);
      figures_.rates_hz[name] =
          (count - (before == counts_before_.end() ? 0 : before->second)) / held_s;
    }
  }

  const FirmwareScenario& scenario_;
  Supervisor& supervisor_;
  base::rpc::Client simulator_;
  base::rpc::Client casd_;
  FlightPlan plan_;
  CallList own_calls_;
  bool was_armed_ = false;   ///< by HEARTBEAT or because it accepted
  bool seen_armed_ = false;  ///< by HEARTBEAT, since it last accepted
  int armed_again_ = 0;
  std::uint64_t acts_so_far_ = 0;
  std::size_t stages_when_armed_ = 0;  ///< the last time
  bool gave_disarm_ = false;           ///< since the newest arming, and it was accepted
  bool armed_before_ = false;          ///< at the look before
  base::SimTime armed_at_;
  base::RunTime armed_wall_{};  ///< the same by this machine's clock
  std::optional<base::SimTime> disarmed_at_;
  double highest_m_ = 0;
  Progress progress_;
  FirmwareFigures figures_;
  Eigen::Vector3d p_W_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d armed_at_N_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d hold_begin_W_ = Eigen::Vector3d::Zero();
  std::string phase_;
  bool holding_ = false;
  double hold_begin_s_ = 0;
  std::map<std::string, double> counts_before_;  ///< when the measured hold began
  std::optional<double> ground_m_;
  double altitude_m_ = 0;
  double height_sum_m_ = 0;
};

}  // namespace

std::string version_fault(const Firmware& wanted, const std::string& version) {
  if (wanted.least_version.empty()) return {};
  if (version.empty()) {
    return fmt::format(
        "the firmware did not tell its version within {:.0f} s, and the scenario is for v{} and "
        "later",
        base::to_seconds(kVersionPatience), wanted.least_version);
  }
  if (is_at_least(version, wanted.least_version)) return {};
  return fmt::format("the firmware is v{}, and the scenario is for v{} and later{}{}", version,
                     wanted.least_version, wanted.hint.empty() ? "" : "; ", wanted.hint);
}

std::string silence_fault(const VehicleReport& vehicle) {
  if (vehicle.heard && vehicle.heartbeat_age_s <= base::to_seconds(kSilencePatience)) return {};
  return fmt::format(
      "the firmware has sent no HEARTBEAT for {:.0f} s; run/firmware.log in the results has what "
      "it says",
      base::to_seconds(kSilencePatience));
}

FirmwareFigures pilot_firmware(const FirmwareScenario& scenario, const FirmwarePlaces& places,
                               Supervisor& supervisor) {
  return FirmwarePilot(scenario, places, supervisor).fly();
}

}  // namespace cas::hils
