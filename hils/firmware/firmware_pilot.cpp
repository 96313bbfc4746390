// SPDX-License-Identifier: BSD-3-Clause
#include "hils/firmware/firmware_pilot.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include "base/rpc/client.hpp"
#include "base/time/unix_time.hpp"
#include "hils/firmware/companion_flight.hpp"
#include "hils/firmware/fence_keeper.hpp"
#include "hils/firmware/firmware_faults.hpp"
#include "hils/firmware/firmware_reboot.hpp"
#include "hils/firmware/first_sign.hpp"
#include "hils/measure/incident.hpp"
#include "hils/programs/pilot_calls.hpp"
#include "hils/programs/progress.hpp"
#include "hils/scenario/fleet_plan.hpp"
#include "mavlink/common/autopilot_version.hpp"
#include "mavlink/common/enums.hpp"

namespace cas::hils {
namespace {

using base::rpc::Json;

constexpr base::Duration kPollPeriod = std::chrono::milliseconds(50);
constexpr base::Duration kCompanionPatience = std::chrono::seconds(20);
/// All in real time.
constexpr base::Duration kVersionPatience = std::chrono::seconds(20);
/// A firmware that has neither connected nor sent a byte by then will not come. PX4 and ArduCopter
/// connect within 2 s.
constexpr base::Duration kFirstSignPatience = std::chrono::seconds(20);
/// For all parameters of a firmware. casd ends a list 10 s after the last new parameter.
constexpr base::Duration kParamPatience = std::chrono::minutes(20);
/// Of a firmware's output, in an error.
constexpr std::size_t kTailLines = 8;
constexpr base::Duration kAskAgain = std::chrono::seconds(3);
constexpr base::Duration kSilencePatience = std::chrono::seconds(30);
/// For giving back the parameters of the fences of a run that is stopped.
constexpr base::Duration kFencePatience = std::chrono::seconds(10);
/// Higher than a landing gear springs, lower than any takeoff of a scenario.
constexpr double kOnGround_m = 0.3;
/// A vehicle on its gear; one that lies on its side or back is tilted by more.
constexpr double kUpright_deg = 30;
/// PX4 disarms 2 s after it has noticed a landing (v1.12.0, v1.16.1), ArduCopter 4.5.6 sooner.
constexpr FirmwareHabits kHabits{
    .arms_early = true, .disarms_itself = std::chrono::seconds(5), .flies_setpoints = true};

/// State shared by all vehicles of a flight.
struct FlightDeck {
  FlightDeck(const FirmwareScenario& flown, const FirmwarePlaces& places, FirmwareBench& programs)
      : scenario(flown),
        bench(programs),
        supervisor(programs.supervisor()),
        run(places.run),
        simulator(connect("unix:" + places.simulator_control().string())),
        casd(connect("unix:" + places.command_port.string())) {}

  const FirmwareScenario& scenario;
  FirmwareBench& bench;
  Supervisor& supervisor;
  std::filesystem::path run;
  base::rpc::Client simulator;
  base::rpc::Client casd;
};

/// Gives the commands of one vehicle's plan and looks at its true position.
class FirmwarePilot {
 public:
  /// @param vehicle  its place in the world. All outlive the pilot.
  /// @param companion  for steps that take more than commands; nothing: the flight has none
  FirmwarePilot(FlightDeck& deck, FlightPlan& plan, std::size_t vehicle, CompanionLink* companion)
      : scenario_(deck.scenario),
        bench_(deck.bench),
        supervisor_(deck.supervisor),
        simulator_(deck.simulator),
        casd_(deck.casd),
        plan_(plan),
        vehicle_(vehicle) {
    if (companion != nullptr) companion_.emplace(*companion, calls(), waiting());
    if (scenario_.flies_several()) asked_ = figures_.system = system_of_instance(vehicle);
    if (!scenario_.fence) return;
    figures_.fence.emplace();
    fence_.emplace(calls(),
                   deck.run / fmt::format("fence_before{}.params", scenario_.suffix_of(vehicle)));
  }

  /// Whether the firmware is there, and may be flown; else the plan has failed. @throws RunStopped
  bool is_there() {
    meet();
    if (!is_of_age()) return false;
    read_params();
    return true;
  }

  /// Puts the scenario's fence in force, where it has one; else the plan has failed.
  void set_fence() {
    if (!fence_) return;
    supervisor_.linger(kFencePatience);
    const std::string autopilot = vehicle_report(casd_, asked_).autopilot;
    if (const auto why = fence_->set(fence_params(autopilot, *scenario_.fence))) {
      plan_.fail("the fence was not set: " + *why);
    }
  }

  /// Gives back the parameters of the fence.
  void restore_fence(base::RunTime deadline) {
    if (!fence_) return;
    figures_.fence->not_restored = has_ended_ ? "the firmware has ended: its fence was not restored"
                                              : fence_->restore(deadline);
    if (const auto& fault = figures_.fence->not_restored) {
      fmt::print(stderr, "hils: {}\n", *fault);
    }
  }

  /// The present state of the vehicle.
  VehicleReport report() {
    VehicleReport vehicle = plan_.from_arming(vehicle_report(casd_, asked_));
    vehicle.truth = truth_;
    if (!vehicle.heard) return vehicle;
    if (companion_) vehicle.mission_reached = companion_->reached();
    note_breach(vehicle);
    if (figures_.version.empty()) figures_.version = vehicle.firmware;
    return vehicle;
  }

  /// The plan fails where the firmware has ended by itself.
  void check_own_end() {
    if (plan_.failure()) return;
    if (const auto end = bench_.own_end(vehicle_, 1)) {
      has_ended_ = true;
      figures_.fell_silent = newest_look();
      plan_.fail(*end);
    }
  }

  /// The plan fails where the vehicle is silent.
  void check_silence(const VehicleReport& vehicle) {
    const auto fault = silence_fault(vehicle);
    if (!fault) return;
    figures_.fell_silent = newest_look() - base::from_seconds(vehicle.heartbeat_age_s);
    plan_.fail(*fault);
  }

  /// Notes the commands of others, of which casd is about to forget a part.
  /// @param ends  casd ends
  void before_forgetting(bool ends) {
    note_interventions();
    if (ends) counts_before_.reset();  // casd's counters restart: no rates for this hold
  }

  /// At the true motion. @return simulated time
  base::SimTime look() {
    if (companion_) companion_->before_look();
    const Json status = simulator_.call("sim.status", Json::object());
    const Json& vehicle = status.at("vehicles").at(vehicle_);
    truth_ = to_motion(vehicle);
    if (!start_m_) start_m_ = truth_.p_m;
    truth_.p_m -= *start_m_;
    highest_m_ = std::max(highest_m_, truth_.p_m.z() - armed_at_m_);
    figures_.real_time_factor = status.value("real_time_factor", 0.0);
    figures_.simulated_s = status.at("time_s").get<double>();
    figures_.log_clock.add(base::unix_us(), to_microseconds(newest_look()));
    if (companion_) companion_->after_look(newest_look());
    return newest_look();
  }

  /// Rates in the measured step, at its begin and its end.
  void measure() {
    const FlightStep* step = plan_.current();
    measure_rates(step != nullptr && step->measure);
  }

  /// Has the vehicle do a step of its plan.
  void give(const FlightStep& command) {
    if (command.kind == StepKind::kArm) {
      armed_at_m_ = truth_.p_m.z();
      highest_m_ = 0;
    }
    if (command.kind == StepKind::kReboot) return reboot(command);
    if (companion_ && CompanionFlight::gives(command.kind)) return give_as_companion(command);
    const std::optional<Refusal> refusal = hils::give(casd_, command, scenario_.not_hil, asked_);
    plan_.on_outcome(look(), refusal);
  }

  /// @param failure  of the flight, if it failed
  FirmwareFigures finish(const std::optional<std::string>& failure) {
    figures_.under_way = plan_.under_way(look());
    figures_.stages = plan_.stages();
    figures_.flight_failure = failure;
    const Pose pose{.roll_rad = truth_.rpy_rad.x(), .pitch_rad = truth_.rpy_rad.y()};
    figures_.disarmed_on_ground = plan_.disarmed_before_takeoff() && highest_m_ <= kOnGround_m &&
                                  tilt_deg(pose) <= kUpright_deg;
    note_interventions();
    if (!interventions_.empty()) {
      figures_.remarks.push_back(
          fmt::format("input from outside the scenario: {}", fmt::join(interventions_, "; ")));
    }
    if (companion_) figures_.setpoints = companion_->setpoints();
    add_losses(casd_.call("link.list", Json::object()), figures_);
    figures_.messages = casd_.call("message.list", Json::object()).dump();
    figures_.hops = casd_.call("link.latency", Json::object()).dump();
    return figures_;
  }

  /// Simulated time then.
  base::SimTime newest_look() const {
    return base::SimTime(base::from_seconds(figures_.simulated_s));
  }
  double real_time_factor() const { return figures_.real_time_factor; }

 private:
  Json asked() const { return asked_ ? Json{{"vehicle", *asked_}} : Json::object(); }

  /// Waits for the firmware's first HEARTBEAT in real time: until the firmware is there, the
  /// simulator's time runs at its own speed and says nothing of how long the firmware takes.
  /// @throws RunStopped where it does not come, or comes from a firmware of another kind
  void meet() {
    const base::RunTime begin = base::steady_now();
    const base::Duration patience = scenario_.steps.front().timeout;
    VehicleReport vehicle;
    while (!(vehicle = vehicle_report(casd_, asked_)).heard) {
      if (const auto end = bench_.own_end(vehicle_, kTailLines)) {
        const std::string& hint = scenario_.firmware.hint;
        throw RunStopped(*end + (hint.empty() ? "" : "\n" + hint), false);
      }
      const base::Duration waited = base::steady_now() - begin;
      if (waited > std::min(kFirstSignPatience, patience)) {
        check_first_sign(waited, waited > patience);
      }
      supervisor_.wait(kPollPeriod);
    }
    if (const auto why = mismatch(vehicle, scenario_.autopilot)) throw RunStopped(*why, false);
    figures_.system = casd_.call("vehicle.state", asked()).value("system", figures_.system);
    if (companion_) companion_->join(companion_link_name(vehicle_));
  }

  /// A firmware of which nothing at all has come is not waited for any longer.
  void check_first_sign(base::Duration waited, bool too_long) {
    const FirstSign sign = first_sign(
        simulator_.call("sim.stats", Json::object()), casd_.call("link.list", Json::object()),
        scenario_.vehicles[vehicle_], scenario_.firmware.on_serial_line);
    if (sign.anything && !too_long) return;
    const std::string which =
        asked_ ? fmt::format(" of the vehicle with system id {}", *asked_) : "";
    throw RunStopped(
        fmt::format("the firmware{} was not heard within {:.0f} s of real time: {}; its last "
                    "lines (run/firmware{}.log):{}",
                    which, base::to_seconds(waited), sign.words, scenario_.suffix_of(vehicle_),
                    bench_.last_lines(vehicle_)),
        false);
  }

  CompanionFlight::Call calls() {
    return [this](const std::string& method, Json params) {
      if (asked_ && !method.starts_with("link.")) params["vehicle"] = *asked_;
      return casd_.call(method, params, kCompanionPatience);
    };
  }

  CompanionFlight::Wait waiting() {
    return [this](base::Duration time) { supervisor_.wait(time); };
  }

  /// Texts before the breach step are not about the breach.
  void note_breach(const VehicleReport& vehicle) {
    const FlightStep* step = plan_.current();
    const bool under_way = step != nullptr && step->kind == StepKind::kBreach && plan_.begun();
    if (companion_ && !under_way) companion_->end_breach();
    if (!fence_) return;
    if (under_way && !breach_began_) breach_began_ = base::steady_now();
    if (!breach_began_ || vehicle.fence_words.empty() || !figures_.fence->words.empty()) return;
    const double ago_s = base::to_seconds(base::steady_now() - *breach_began_);
    if (vehicle.fence_words_age_s < ago_s) figures_.fence->words = vehicle.fence_words;
  }

  /// A trajectory, a mission or a breach.
  void give_as_companion(const FlightStep& command) {
    const Eigen::Vector3d& wanted_m = plan_.reference_m();
    const CompanionFlight::Answer answer = companion_->give(
        command,
        {.autopilot = vehicle_report(casd_, asked_).autopilot,
         .hover_N = plan_.armed_at_N() + Eigen::Vector3d(wanted_m.x(), wanted_m.y(), -wanted_m.z()),
         .armed_at_N = plan_.armed_at_N(),
         .yaw_rad = plan_.reference_yaw_rad(),
         .not_hil = scenario_.not_hil});
    if (answer.for_good) return plan_.fail(*answer.refusal);
    if (answer.mission) plan_.aim(*answer.mission);
    const base::SimTime now = look();
    std::optional<Refusal> refusal;
    if (answer.refusal) refusal = Refusal{*answer.refusal};
    plan_.on_outcome(answer.begin.value_or(now), refusal);
  }

  /// Other vehicles fly on meanwhile, and their plans wait.
  void reboot(const FlightStep& step) {
    if (vehicle_report(casd_, asked_).armed) {
      return plan_.fail("the vehicle is armed: its firmware is not rebooted");
    }
    const FirmwareReboot reboot{
        .restart = [this] { bench_.reboot(vehicle_); },
        .look = [this] { return look(); },
        .heartbeats = [this] { return counts()["HEARTBEAT"]; },
        .wait = waiting(),
        .parameter = [this](const std::string& name) { return parameter(name.c_str()); }};
    const base::SimTime written_at =
        plan_.stages().empty() ? base::SimTime{} : plan_.stages().back().end;
    const auto fault = reboot.run(written_params(plan_.stages()), written_at, step.timeout);
    if (fault) return plan_.fail(*fault);
    if (companion_) companion_->on_reboot();
    plan_.on_outcome(look());
  }

  /// Commands of others to the vehicle, as casd saw them or was called for them.
  void note_interventions() {
    const std::string own =
        fmt::format("{} on link {}", CompanionStation::kSelfText, companion_link_name(vehicle_));
    for (const HeardAct& act : vehicle_report(casd_, asked_).acts) {
      if (act.by != own) interventions_.insert(act.by + ": " + act.what);
    }
    for (const OutsideCall& call : read_outside_calls(casd_)) {
      const bool its = !asked_ || call.system == 0 || call.system == *asked_;
      if (!its || !is_act(call)) continue;
      interventions_.insert(fmt::format("{} called {}{}", call.client, call.method,
                                        call.params == "{}" ? "" : " " + call.params));
    }
  }

  std::optional<double> parameter(const char* name) {
    try {
      Json params = asked();
      params["name"] = name;
      return casd_.call("param.get", params).at("value").get<double>();
    } catch (const base::rpc::CallError&) {
      return std::nullopt;  // it has none of this name, or does not answer
    }
  }

  /// Waits until the firmware reports the version that the scenario wants, and repeats the request:
  /// casd's own, upon the first HEARTBEAT, may have come too early.
  bool is_of_age() {
    const base::RunTime deadline = base::steady_now() + kVersionPatience;
    for (base::RunTime ask_at = base::steady_now() + kAskAgain;;) {
      figures_.version = vehicle_report(casd_, asked_).firmware;
      const bool wanted = !scenario_.firmware.least_version.empty();
      if (!wanted || !figures_.version.empty() || base::steady_now() > deadline) break;
      if (base::steady_now() > ask_at) {
        ask_for_version();
        ask_at = base::steady_now() + kAskAgain;
      }
      supervisor_.wait(kPollPeriod);
    }
    const auto fault = version_fault(scenario_.firmware, figures_.version);
    if (fault) plan_.fail(*fault);
    if (!scenario_.firmware.least_version.empty() && is_of_a_tree_without_tags(figures_.version)) {
      figures_.remarks.push_back(fmt::format(
          "the firmware says v{}, as a tree cloned without tags does: firmware.least_version ({}) "
          "was not checked",
          figures_.version, scenario_.firmware.least_version));
    }
    return !fault;
  }

  /// Before the first step: an autopilot counts flights and hours in its parameters later.
  void read_params() {
    try {
      const Json answer = casd_.call("param.list", asked(), kParamPatience);
      figures_.params = digest_of(answer.at("parameters"));
    } catch (const base::rpc::CallError& error) {
      figures_.remarks.push_back(std::string("the firmware's parameters were not read: ") +
                                 error.what());
    }
  }

  /// A refusal means that it has none to tell, or not yet.
  void ask_for_version() {
    Json params = asked();
    params["command"] = static_cast<int>(mavlink::common::MavCmd::kRequestMessage);
    params["params"] = {mavlink::common::AutopilotVersion::kId};
    try {
      casd_.call("vehicle.command", params);
    } catch (const base::rpc::CallError&) {
    }
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
    if (!(held_s > 0) || !counts_before_) return;
    for (const auto& [name, count] : now) {
      const auto before = counts_before_->find(name);
      figures_.rates_hz[name] =
          (count - (before == counts_before_->end() ? 0 : before->second)) / held_s;
    }
  }

  const FirmwareScenario& scenario_;
  FirmwareBench& bench_;
  Supervisor& supervisor_;
  base::rpc::Client& simulator_;
  base::rpc::Client& casd_;
  FlightPlan& plan_;
  std::size_t vehicle_;
  AskedVehicle asked_;  ///< how casd is to name it
  std::optional<CompanionFlight> companion_;
  std::optional<FenceKeeper> fence_;
  std::optional<base::RunTime> breach_began_;  ///< the first step of this kind
  bool has_ended_ = false;                     ///< its program, by itself
  double armed_at_m_ = 0;                      ///< true height at the newest arming, from start_m_
  double highest_m_ = 0;                       ///< true height since then, above that place
  std::set<std::string> interventions_;
  FirmwareFigures figures_;
  bool holding_ = false;
  double hold_begin_s_ = 0;
  /// When the measured hold began; nullopt: casd has ended since.
  std::optional<std::map<std::string, double>> counts_before_;
  Motion truth_;
  std::optional<Eigen::Vector3d> start_m_;  ///< true, at the first look
};

FleetPlan fleet_of(const FirmwareScenario& scenario) {
  std::vector<FlightPlan> plans;
  for (std::size_t i = 0; i < scenario.vehicles.size(); ++i) {
    plans.emplace_back(steps_for(i, scenario.steps), scenario.start_yaw_rad.at(i), kHabits);
  }
  return {scenario.vehicles, std::move(plans)};
}

/// Takes the vehicles through their steps together.
class FirmwareFleet {
 public:
  FirmwareFleet(const FirmwareScenario& scenario, const FirmwarePlaces& places,
                FirmwareBench& bench, std::span<const std::unique_ptr<CompanionLink>> links)
      : deck_(scenario, places, bench),
        plan_(fleet_of(scenario)),
        faults_(scenario.faults.bench, reach_of_faults(places)) {
    for (std::size_t i = 0; i < scenario.vehicles.size(); ++i) {
      pilots_.push_back(std::make_unique<FirmwarePilot>(deck_, plan_.plan(i), i,
                                                        links.empty() ? nullptr : links[i].get()));
    }
  }

  /// @throws RunStopped, base::rpc::ConnectionError; the fences are restored even then
  std::vector<FirmwareFigures> fly() {
    try {
      fly_steps();
      restore_fences();
      return finish();
    } catch (...) {
      if (deck_.scenario.fence) go_on_for_a_moment();
      restore_fences();
      throw;
    }
  }

 private:
  void fly_steps() {
    for (const auto& pilot : pilots_) {
      if (!pilot->is_there()) return;
    }
    for (const auto& pilot : pilots_) pilot->set_fence();
    for (base::SimTime now = look(); !plan_.ended();) {
      faults_.play(now, reports_, plan_.phase());
      now = look();
      for (const auto& pilot : pilots_) pilot->check_own_end();
      if (waits_for_vehicles()) {
        deck_.supervisor.wait(kPollPeriod);
        continue;
      }
      const std::vector<FleetPlan::Command> commands = plan_.update(now, reports_);
      send_phase(deck_.simulator, plan_.phase(), phase_);
      for (const auto& pilot : pilots_) pilot->measure();
      show(now);
      for (const FleetPlan::Command& command : commands) {
        if (!plan_.ended()) pilots_[command.vehicle]->give(command.step);
      }
      if (commands.empty()) deck_.supervisor.wait(kPollPeriod);
    }
    send_phase(deck_.simulator, plan_.phase(), phase_);
  }

  void restore_fences() {
    const base::RunTime deadline = base::steady_now() + kFencePatience;
    for (const auto& pilot : pilots_) pilot->restore_fence(deadline);
    deck_.supervisor.end_lingering();
  }

  /// A firmware in lockstep does not answer while a fault has paused the simulator.
  void go_on_for_a_moment() {
    try {
      deck_.simulator.call("sim.resume", Json::object());
    } catch (const std::exception&) {  // the simulator itself may have ended
    }
  }

  FirmwareFaults::Reach reach_of_faults(const FirmwarePlaces& places) {
    return {.bench = deck_.bench,
            .simulator = deck_.simulator,
            .casd = deck_.casd,
            .casd_address = "unix:" + places.command_port.string(),
            .before_forgetting = [this](bool ends) {
              for (const auto& pilot : pilots_) pilot->before_forgetting(ends);
            }};
  }

  /// While casd is away, the reports are those of the last look before.
  base::SimTime look() {
    base::SimTime now;
    reports_.resize(pilots_.size());
    for (std::size_t i = 0; i < pilots_.size(); ++i) {
      now = pilots_[i]->look();
      if (!faults_.casd_is_away()) reports_[i] = pilots_[i]->report();
    }
    return now;
  }

  /// Whether nothing is known of a vehicle because of a fault: the steps go on when it is heard
  /// again. A plan fails where a vehicle is silent for another reason.
  bool waits_for_vehicles() {
    if (faults_.casd_is_away()) return true;
    const bool excused = faults_.excuses_silence(base::steady_now());
    const auto heard = [](const VehicleReport& vehicle) { return vehicle.heard; };
    if (excused) return !std::ranges::all_of(reports_, heard);
    for (std::size_t i = 0; i < pilots_.size(); ++i) pilots_[i]->check_silence(reports_[i]);
    return false;
  }

  void show(base::SimTime now) {
    const std::size_t leader = plan_.leader();
    progress_.show(now, plan_.plan(leader), reports_[leader],
                   pace_words(pilots_[leader]->real_time_factor()));
  }

  std::vector<FirmwareFigures> finish() {
    std::vector<FirmwareFigures> all;
    for (std::size_t i = 0; i < pilots_.size(); ++i) {
      all.push_back(pilots_[i]->finish(plan_.failure_of(i)));
      all.back().bench_faults = all.back().faults = faults_.history_of(i);
    }
    return all;
  }

  FlightDeck deck_;
  FleetPlan plan_;
  FirmwareFaults faults_;
  std::vector<std::unique_ptr<FirmwarePilot>> pilots_;
  std::vector<VehicleReport> reports_;  ///< of the newest look
  std::string phase_;
  Progress progress_;
};

}  // namespace

std::optional<std::string> version_fault(const Firmware& wanted, const std::string& version) {
  if (wanted.least_version.empty()) return std::nullopt;
  if (version.empty()) {
    return fmt::format(
        "the firmware did not tell its version within {:.0f} s, and firmware.least_version is {}",
        base::to_seconds(kVersionPatience), wanted.least_version);
  }
  if (is_of_a_tree_without_tags(version)) return std::nullopt;
  if (is_at_least(version, wanted.least_version)) return std::nullopt;
  return fmt::format("the firmware is v{}, and firmware.least_version is {}", version,
                     wanted.least_version);
}

std::optional<std::string> silence_fault(const VehicleReport& vehicle) {
  if (vehicle.heard && vehicle.heartbeat_age_s <= base::to_seconds(kSilencePatience)) {
    return std::nullopt;
  }
  return fmt::format(
      "the firmware has sent no HEARTBEAT for {:.0f} s; run/firmware.log in the results has what "
      "it says",
      base::to_seconds(kSilencePatience));
}

std::vector<FirmwareFigures> pilot_firmware(const FirmwareScenario& scenario,
                                            const FirmwarePlaces& places, FirmwareBench& bench,
                                            std::span<const std::unique_ptr<CompanionLink>> links) {
  return FirmwareFleet(scenario, places, bench, links).fly();
}

}  // namespace cas::hils
