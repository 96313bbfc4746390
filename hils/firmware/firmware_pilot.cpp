// SPDX-License-Identifier: BSD-3-Clause
#include "hils/firmware/firmware_pilot.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <exception>
#include <map>
#include <nlohmann/json.hpp>
#include <string_view>
#include <utility>

#include "base/time/unix_time.hpp"
#include "hils/firmware/companion_flight.hpp"
#include "hils/firmware/external_ahrs.hpp"
#include "hils/firmware/fence_keeper.hpp"
#include "hils/firmware/firmware_composition.hpp"
#include "hils/firmware/firmware_faults.hpp"
#include "hils/firmware/firmware_meeting.hpp"
#include "hils/firmware/firmware_reboot.hpp"
#include "hils/firmware/flight_deck.hpp"
#include "hils/firmware/line_disarm.hpp"
#include "hils/flight/flight_loop.hpp"
#include "hils/measure/incident.hpp"
#include "hils/programs/page_watch.hpp"
#include "hils/programs/progress.hpp"
#include "hils/programs/scenario_flight.hpp"

namespace cas::hils {
namespace {

using base::rpc::Json;

constexpr base::Duration kCompanionPatience = std::chrono::seconds(20);
constexpr base::Duration kSilencePatience = std::chrono::seconds(30);
constexpr base::Duration kBetweenLineLooks = std::chrono::seconds(1);
/// What an older one says may be over.
constexpr base::Duration kFreshHeartbeat = std::chrono::seconds(3);
/// For the last calls to the vehicles of a run that is stopped.
constexpr base::Duration kLastCallPatience = std::chrono::seconds(10);
/// Higher than a landing gear springs, lower than any takeoff of a scenario.
constexpr double kOnGround_m = 0.3;
/// A vehicle on its gear; one that lies on its side or back is tilted by more.
constexpr double kUpright_deg = 30;
/// PX4 disarms 2 s after it has noticed a landing (v1.12.0, v1.16.1), ArduCopter 4.5.6 sooner.
constexpr FirmwareHabits kHabits{
    .arms_early = true, .disarms_itself = std::chrono::seconds(5), .flies_setpoints = true};

/// How many of each message a vehicle has sent, on the link of casd that has most of them.
std::map<std::string, double> message_counts(base::rpc::Client& casd, std::uint8_t system) {
  std::map<std::string, double> all;
  for (const Json& row : casd.call("message.list", Json::object())) {
    if (row.value("direction", "") != "rx" || row.value("system", 0) != system) continue;
    double& count = all[row.value("name", "")];
    count = std::max(count, row.value("count", 0.0));
  }
  return all;
}

/// One vehicle in flight: looks at it, has it do steps, collects its figures.
class FirmwareVehicle {
 public:
  /// @param vehicle  its place in the world. All outlive this object.
  /// @param companion  for steps that take more than commands; nothing: the flight has none
  /// @param record  which it fills in
  FirmwareVehicle(FlightDeck& deck, FlightPlan& plan, std::size_t vehicle, CompanionLink* companion,
                  RunRecord& record)
      : deck_(deck), plan_(plan), vehicle_(vehicle), record_(record) {
    record_.firmware.emplace().autopilot = deck.scenario.firmware->autopilot;
    const Scenario& scenario = deck.scenario;
    if (companion != nullptr) companion_.emplace(*companion, calls(), waiting());
    if (scenario.flies_several()) asked_ = record_.system = system_of_instance(vehicle);
    if (!scenario.fence) return;
    record_.firmware->fence.emplace();
    fence_.emplace(calls(),
                   deck.run / fmt::format("fence_before{}.params", scenario.suffix_of(vehicle)));
  }

  /// Whether the firmware is there, and may be flown; else the plan has failed. @throws RunStopped
  bool is_there() {
    if (const auto fault = meet_firmware(deck_, vehicle_, asked_, record_)) {
      plan_.fail(*fault);
      return false;
    }
    if (deck_.scenario.firmware->external_ahrs) {
      const std::string& name = deck_.scenario.vehicles[vehicle_].name;
      if (const auto fault = prepare_external_ahrs(deck_, asked_, name)) {
        plan_.fail(*fault);
        return false;
      }
    }
    if (companion_) companion_->join(companion_link_name(vehicle_));
    if (deck_.scenario.firmware->tells_origin) companion_->set_origin(*deck_.scenario.home);
    return true;
  }

  /// Puts the scenario's fence in force, where it has one; else the plan has failed.
  void set_fence() {
    if (!fence_) return;
    const std::string autopilot = vehicle_report(deck_.casd, asked_).autopilot;
    if (const auto why = fence_->set(fence_params(autopilot, *deck_.scenario.fence))) {
      plan_.fail("the fence was not set: " + *why);
    }
  }

  /// Gives back the parameters of the fence.
  void restore_fence(base::RunTime deadline) {
    if (!fence_) return;
    record_.firmware->fence->not_restored =
        has_ended_ ? "the firmware has ended: its fence was not restored"
                   : fence_->restore(deadline);
    if (const auto& fault = record_.firmware->fence->not_restored)
      fmt::print(stderr, "hils: {}\n", *fault);
  }

  void lose_sticks(bool lost) {
    if (companion_) companion_->lose_sticks(lost);
  }

  /// Around each look at the simulation.
  void before_look() {
    if (companion_) companion_->before_look();
  }

  void after_look() {
    const base::SimTime now = deck_.simulator.status().time;
    highest_m_ =
        std::max(highest_m_, deck_.simulator.status().truth.at(vehicle_).p_m.z() - armed_at_m_);
    record_.firmware->real_time_factor = deck_.simulator.status().real_time_factor;
    record_.simulated_s = base::to_seconds(now);
    record_.log_clock.add(base::unix_us(), to_microseconds(now));
    if (companion_) companion_->after_look(now);
  }

  VehicleReport report() {
    VehicleReport vehicle = vehicle_report(deck_.casd, asked_);
    if (!vehicle.heard) return vehicle;
    if (companion_) vehicle.mission_reached = companion_->reached();
    note_breach(vehicle);
    if (record_.firmware->version.empty()) record_.firmware->version = vehicle.firmware;
    return vehicle;
  }

  /// The plan fails where the firmware has ended by itself.
  void check_own_end() {
    if (plan_.failure()) return;
    if (const auto end = deck_.bench.own_end(vehicle_, 1)) {
      has_ended_ = true;
      record_.firmware->fell_silent = deck_.simulator.status().time;
      plan_.fail(*end);
    }
  }

  /// The plan fails where the vehicle is silent.
  void check_silence(const VehicleReport& vehicle) {
    const auto fault = silence_fault(vehicle);
    if (!fault) return;
    record_.firmware->fell_silent =
        deck_.simulator.status().time - base::from_seconds(vehicle.heartbeat_age_s);
    plan_.fail(*fault);
  }

  /// Rates of its messages in the measured step, from one end of it to the other.
  void measure() {
    const FlightStep* step = plan_.current();
    const bool measuring = step != nullptr && step->measure;
    if (measuring == std::exchange(measuring_, measuring)) return;
    std::map<std::string, double> counts = message_counts(deck_.casd, record_.system);
    if (measuring) {
      counts_before_ = std::move(counts);
      measured_from_s_ = record_.simulated_s;
      return;
    }
    const double lasted_s = record_.simulated_s - measured_from_s_;
    if (!(lasted_s > 0) || !counts_before_) return;
    for (const auto& [name, count] : counts) {
      record_.firmware->rates_hz[name] = (count - (*counts_before_)[name]) / lasted_s;
    }
  }

  /// A board without its sensors flies on with live outputs: its flight is over.
  void check_sensors_line() {
    if (!deck_.scenario.firmware->external_ahrs || plan_.failure()) return;
    const base::RunTime now = base::steady_now();
    if (now < next_line_look_) return;
    next_line_look_ = now + kBetweenLineLooks;
    const Json unit = external_ahrs_unit(deck_, deck_.scenario.vehicles[vehicle_].name);
    if (unit.value("up", true)) return;
    plan_.fail("the sensors' line is gone: " + unit.value("endpoint", ""));
  }

  /// The outputs of this vehicle are live: it is not left armed, however its flight has ended.
  void leave_disarmed() {
    if (has_ended_) return;
    std::optional<std::string> fault;
    try {
      const VehicleReport now = vehicle_report(deck_.casd, asked_);
      const bool is_fresh = now.heard && now.heartbeat_age_s <= base::to_seconds(kFreshHeartbeat);
      if (is_fresh && !now.armed) return;
      deck_.casd.call("vehicle.disarm", about(asked_, {{"force", true}}), kCompanionPatience);
    } catch (const base::rpc::ConnectionError&) {
      deck_.bench.kill_casd();  // where it does not answer, it has the line
      fault = disarm_by_line(deck_.vehicle_line, {.system = record_.system, .component = 1});
    } catch (const std::exception& error) {
      fault = error.what();
    }
    if (!fault) {
      fmt::print(stderr, "hils: the board was still armed at the end, and has been disarmed\n");
      return;
    }
    fmt::print(stderr,
               "hils: THE BOARD COULD NOT BE DISARMED ({}): do it by its transmitter, its ground "
               "station or its power\n",
               *fault);
  }

  /// casd's counters restart: no rates for this hold.
  void before_casd_ends() { counts_before_.reset(); }

  /// Has the vehicle do a step of its plan, unless the plan fails.
  void give(const FlightStep& step, const FlightBench::Answer& answer) {
    if (step.kind == StepKind::kArm) {
      armed_at_m_ = deck_.simulator.status().truth.at(vehicle_).p_m.z();
      highest_m_ = 0;
    }
    if (step.kind == StepKind::kReboot) return reboot(step, answer);
    if (companion_ && CompanionFlight::gives(step.kind)) return give_as_companion(step, answer);
    const auto refusal = hils::give(deck_.casd, step, deck_.scenario.firmware->not_hil, asked_,
                                    vehicle_report(deck_.casd, asked_).autopilot);
    answer(deck_.look(), refusal);
  }

  void finish(const Flight& flight) {
    record_flight(flight, vehicle_, deck_.look(), record_);
    record_.firmware->bench_faults = record_.faults;
    const Motion& truth = deck_.simulator.status().truth.at(vehicle_);
    const Pose pose{.roll_rad = truth.rpy_rad.x(), .pitch_rad = truth.rpy_rad.y()};
    record_.firmware->disarmed_on_ground = plan_.disarmed_before_takeoff() &&
                                           highest_m_ <= kOnGround_m &&
                                           tilt_deg(pose) <= kUpright_deg;
    if (companion_) record_.firmware->setpoints = companion_->setpoints();
    add_losses(deck_.casd.call("link.list", Json::object()), *record_.firmware);
    record_.firmware->messages = deck_.casd.call("message.list", Json::object()).dump();
    record_.firmware->hops = deck_.casd.call("link.latency", Json::object()).dump();
  }

 private:
  CompanionFlight::Call calls() {
    return [this](const std::string& method, Json params) {
      if (!method.starts_with("link.")) params = about(asked_, std::move(params));
      return deck_.casd.call(method, params, kCompanionPatience);
    };
  }

  CompanionFlight::Wait waiting() {
    return [this](base::Duration time) { deck_.supervisor.wait(time); };
  }

  /// Texts before the breach step are not about the breach.
  void note_breach(const VehicleReport& vehicle) {
    const FlightStep* step = plan_.current();
    const bool under_way = step != nullptr && step->kind == StepKind::kBreach && plan_.begun();
    if (companion_ && !under_way) companion_->end_breach();
    if (!fence_) return;
    if (under_way && !breach_began_) breach_began_ = base::steady_now();
    if (!breach_began_ || vehicle.fence_words.empty() || !record_.firmware->fence->words.empty())
      return;
    const double ago_s = base::to_seconds(base::steady_now() - *breach_began_);
    if (vehicle.fence_words_age_s < ago_s) record_.firmware->fence->words = vehicle.fence_words;
  }

  /// A trajectory, a mission or a breach.
  void give_as_companion(const FlightStep& step, const FlightBench::Answer& answer) {
    const Eigen::Vector3d& wanted_m = plan_.reference_m();
    const CompanionFlight::Answer given = companion_->give(
        step,
        {.autopilot = vehicle_report(deck_.casd, asked_).autopilot,
         .hover_N = plan_.armed_at_N() + Eigen::Vector3d(wanted_m.x(), wanted_m.y(), -wanted_m.z()),
         .armed_at_N = plan_.armed_at_N(),
         .yaw_rad = plan_.reference_yaw_rad(),
         .not_hil = deck_.scenario.firmware->not_hil});
    if (given.for_good) return plan_.fail(*given.refusal);
    if (given.mission) plan_.aim(*given.mission);
    const base::SimTime now = deck_.look();
    std::optional<Refusal> refusal;
    if (given.refusal) refusal = Refusal{*given.refusal};
    answer(given.begin.value_or(now), refusal);
  }

  /// Other vehicles fly on meanwhile, and their plans wait.
  void reboot(const FlightStep& step, const FlightBench::Answer& answer) {
    if (vehicle_report(deck_.casd, asked_).armed) {
      return plan_.fail("the vehicle is armed: its firmware is not rebooted");
    }
    const FirmwareReboot reboot{
        .restart =
            [this] {
              if (!deck_.bench.is_board()) return deck_.bench.reboot(vehicle_);
              deck_.casd.call("vehicle.reboot",
                              about(asked_, {{"not_hil", deck_.scenario.firmware->not_hil}}),
                              kCompanionPatience);
            },
        .look = deck_.look,
        .heartbeats = [this] { return message_counts(deck_.casd, record_.system)["HEARTBEAT"]; },
        .wait = waiting(),
        .parameter = [this](const std::string& name) { return parameter(name); }};
    const base::SimTime written_at =
        plan_.stages().empty() ? base::SimTime{} : plan_.stages().back().end;
    const auto fault = reboot.run(written_params(plan_.stages()), written_at, step.timeout);
    if (fault) return plan_.fail(*fault);
    if (companion_) companion_->on_reboot();
    answer(deck_.look(), std::nullopt);
  }

  std::optional<double> parameter(const std::string& name) {
    try {
      return deck_.casd.call("param.get", about(asked_, {{"name", name}}))
          .at("value")
          .get<double>();
    } catch (const base::rpc::CallError&) {
      return std::nullopt;  // it has none of this name, or does not answer
    }
  }

  FlightDeck& deck_;
  FlightPlan& plan_;
  std::size_t vehicle_;
  AskedVehicle asked_;  ///< how casd is to name it
  std::optional<CompanionFlight> companion_;
  std::optional<FenceKeeper> fence_;
  std::optional<base::RunTime> breach_began_;  ///< the first step of this kind
  bool has_ended_ = false;                     ///< its program, by itself
  base::RunTime next_line_look_{};             ///< at the sensors' line
  double armed_at_m_ = 0;                      ///< true height at the newest arming
  double highest_m_ = 0;                       ///< true height since then, above that place
  bool measuring_ = false;
  double measured_from_s_ = 0;
  /// When the measured step began; nullopt: casd has ended since.
  std::optional<std::map<std::string, double>> counts_before_;
  RunRecord& record_;
};

/// Flies vehicles with stock firmware.
class FirmwareFlight final : public FlightBench {
 public:
  FirmwareFlight(const RunRequest& request, const RunPaths& paths, FirmwareBench& bench,
                 std::span<const std::unique_ptr<CompanionLink>> links,
                 std::vector<RunRecord>& records)
      : deck_(request.scenario, paths, bench),
        records_(records),
        live_(request.live),
        watch_(request.live, deck_.simulator,
               [this] { return faults_.casd_is_away() ? nullptr : &deck_.casd; }),
        faults_(
            deck_,
            [this] {
              watch_.before_casd_ends();
              for (const auto& vehicle : vehicles_) vehicle->before_casd_ends();
            },
            [this](bool lost) {
              for (const auto& vehicle : vehicles_) vehicle->lose_sticks(lost);
            }),
        loop_({request.scenario.names(), request.scenario.steps, request.scenario.start_yaws_rad(),
               request.scenario.faults.bench, kHabits},
              *this) {
    const Scenario& scenario = request.scenario;
    deck_.look = [this] { return look(); };
    const FcuDevice* board = request.fcu_device(0);
    deck_.vehicle_line = board != nullptr ? *board : FcuDevice{.path = paths.casd_tty().string()};
    for (std::size_t i = 0; i < scenario.vehicles.size(); ++i) {
      vehicles_.push_back(
          std::make_unique<FirmwareVehicle>(deck_, loop_.flight().plan.plan(i), i,
                                            links.empty() ? nullptr : links[i].get(), records_[i]));
    }
  }

  /// @throws RunStopped, base::rpc::ConnectionError; the fences are restored even then
  void fly() {
    try {
      fly_steps();
      faults_.end_restart();
      leave_disarmed();
      restore_fences();
      finish();
    } catch (...) {
      leave_disarmed();
      if (deck_.scenario.fence) go_on_for_a_moment();
      restore_fences();
      throw;
    }
  }

  base::SimTime look() override {
    for (const auto& vehicle : vehicles_) vehicle->before_look();
    const base::SimTime now = deck_.simulator.look();
    for (const auto& vehicle : vehicles_) vehicle->after_look();
    return now;
  }
  Motion truth(std::size_t vehicle) const override {
    return deck_.simulator.status().truth.at(vehicle);
  }

  /// Nothing is known of a vehicle that is silent because of a fault.
  std::optional<VehicleReport> report(std::size_t vehicle) override {
    if (faults_.casd_is_away()) return std::nullopt;
    VehicleReport report = vehicles_[vehicle]->report();
    if (!report.heard && faults_.excuses_silence(base::steady_now())) return std::nullopt;
    return report;
  }

  void before_steps(Flight& flight, base::SimTime) override {
    watch_.before_steps();
    for (const auto& vehicle : vehicles_) {
      vehicle->check_own_end();
      vehicle->check_sensors_line();
    }
    const bool is_paused = deck_.simulator.status().paused;  // in lockstep the firmware stops, too
    if (is_paused || faults_.excuses_silence(base::steady_now())) return;
    for (std::size_t i = 0; i < vehicles_.size(); ++i) {
      vehicles_[i]->check_silence(flight.vehicles[i]);
    }
  }
  void after_steps(Flight& flight, base::SimTime now) override {
    watch_.after_steps(flight, now, [&](const BenchFault& fault) { play(flight, fault, true); });
    for (const auto& vehicle : vehicles_) vehicle->measure();
  }
  void tell_phase(std::string_view phase) override { deck_.simulator.tell_phase(phase); }
  void play(const Flight& flight, const BenchFault& fault, bool begins) override {
    faults_.play(flight.faults, fault, begins);
  }
  void show(base::SimTime now, const FlightPlan& plan, const VehicleReport& vehicle) override {
    progress_.show(now, plan, vehicle, pace_words(deck_.simulator.status().real_time_factor));
  }
  void give(Flight&, std::size_t vehicle, const FlightStep& step, Answer answer) override {
    if (faults_.casd_is_away())
      return answer(deck_.simulator.status().time, Refusal{"casd is away"});
    vehicles_[vehicle]->give(step, answer);
  }

 private:
  void fly_steps() {
    for (const auto& vehicle : vehicles_) {
      if (!vehicle->is_there()) return;
    }
    if (deck_.scenario.fence || deck_.scenario.firmware->external_ahrs) {
      deck_.supervisor.linger(kLastCallPatience);
    }
    for (const auto& vehicle : vehicles_) vehicle->set_fence();
    if (loop_.flight().plan.ended()) return;
    loop_.fly([this](bool commanded) {
      if (!commanded) deck_.supervisor.wait(FlightPlan::kLookPeriod);
    });
  }

  /// Disarms the vehicles with live outputs.
  void leave_disarmed() {
    if (!deck_.scenario.firmware->external_ahrs) return;
    for (const auto& vehicle : vehicles_) vehicle->leave_disarmed();
  }

  void restore_fences() {
    const base::RunTime deadline = base::steady_now() + kLastCallPatience;
    for (const auto& vehicle : vehicles_) vehicle->restore_fence(deadline);
    deck_.supervisor.end_lingering();
  }

  /// A firmware in lockstep does not answer while a fault has paused the simulator.
  void go_on_for_a_moment() {
    try {
      deck_.simulator.client().call("sim.resume", Json::object());
    } catch (const std::exception&) {  // the simulator itself may have ended
    }
  }

  void finish() {
    if (live_ != nullptr) live_->end_flight();
    const std::vector<OutsideCall> calls = watch_.finish();
    for (std::size_t i = 0; i < vehicles_.size(); ++i) {
      vehicles_[i]->finish(loop_.flight());
      records_[i].outside_calls = calls;
    }
  }

  FlightDeck deck_;
  std::vector<RunRecord>& records_;
  LiveRun* live_;  ///< nullptr without a page
  PageWatch watch_;
  std::vector<std::unique_ptr<FirmwareVehicle>> vehicles_;
  FirmwareFaults faults_;
  FlightLoop loop_;
  Progress progress_;
};

}  // namespace

std::optional<std::string> silence_fault(const VehicleReport& vehicle) {
  if (vehicle.heard && vehicle.heartbeat_age_s <= base::to_seconds(kSilencePatience)) {
    return std::nullopt;
  }
  return fmt::format(
      "the firmware has sent no HEARTBEAT for {:.0f} s; run/firmware.log in the results has what "
      "it says",
      base::to_seconds(kSilencePatience));
}

void pilot_firmware(const RunRequest& request, const RunPaths& paths, FirmwareBench& bench,
                    std::span<const std::unique_ptr<CompanionLink>> links,
                    std::vector<RunRecord>& records) {
  FirmwareFlight(request, paths, bench, links, records).fly();
}

}  // namespace cas::hils
