// SPDX-License-Identifier: BSD-3-Clause
#include "hils/firmware/firmware_run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>

#include "base/config/install_paths.hpp"
#include "base/error.hpp"
#include "base/os/write_file.hpp"
#include "base/rpc/client.hpp"
#include "hils/firmware/disarming.hpp"
#include "hils/firmware/firmware_report.hpp"
#include "hils/firmware/firmware_scenario.hpp"
#include "hils/firmware/pty_cable.hpp"
#include "hils/measure/judgement.hpp"
#include "hils/measure/run_record.hpp"
#include "hils/measure/tracking.hpp"
#include "hils/programs/pilot_calls.hpp"
#include "hils/programs/progress.hpp"
#include "hils/programs/supervisor.hpp"
#include "hils/programs/watch_line.hpp"
#include "hils/replay/replay_command.hpp"
#include "hils/replay/replay_page.hpp"
#include "hils/replay/replay_record.hpp"
#include "hils/report/report.hpp"
#include "hils/report/results_folder.hpp"
#include "hils/run/run_places.hpp"
#include "mavlink/common/autopilot_version.hpp"
#include "mavlink/common/enums.hpp"

namespace cas::hils {
namespace {

using base::rpc::Json;

constexpr base::Duration kReadyTimeout = std::chrono::seconds(20);
constexpr base::Duration kStopPatience = std::chrono::seconds(5);
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

std::filesystem::path program(const std::string& name) {
  return std::filesystem::read_symlink("/proc/self/exe").parent_path() / name;
}

/// casd, hilsim and the firmware, in this order, so that the firmware finds its peers.
class FirmwareBench {
 public:
  FirmwareBench(const FirmwareScenario& scenario, const FirmwarePlaces& places)
      : scenario_(scenario), places_(places) {
    if (scenario.firmware.on_serial_line) cable_.emplace(places.casd_tty(), places.firmware_tty());
  }

  void start() {
    casd_ = &supervisor_.start(
        options("casd", {program("casd"), places_.casd_config(), "--name", scenario_.name}),
        kReadyTimeout);
    tell_how_to_watch(places_.command_port, std::nullopt);
    std::vector<std::string> hilsim{program("hilsim"), places_.simulator_config(),
                                    "--control",       places_.simulator_control(),
                                    "--output",        places_.out,
                                    "--stats",         places_.simulator_stats()};
    for (const std::filesystem::path& folder : base::plugin_dirs()) {
      hilsim.insert(hilsim.end(), {"--plugin-dir", folder});
    }
    hilsim_ = &supervisor_.start(options("hilsim", hilsim), kReadyTimeout);
    firmware_ = &supervisor_.start(firmware_options(), kReadyTimeout);
  }

  /// The exit code of the firmware says nothing about the flight.
  void stop() {
    supervisor_.stop(*firmware_, kStopPatience);
    supervisor_.stop(*hilsim_, kStopPatience);
    supervisor_.stop(*casd_, kStopPatience);
  }

  Supervisor& supervisor() { return supervisor_; }

  /// Bytes that the serial line lost because a program did not read them.
  std::uint64_t lost_bytes() const { return cable_ ? cable_->lost_bytes() : 0; }

 private:
  ChildProcess::Options options(const std::string& name, std::vector<std::string> arguments) const {
    ChildProcess::Options options;
    options.name = name;
    options.arguments = std::move(arguments);
    options.log_file = places_.run / (name + ".log");
    options.notify_socket = places_.sockets / (name + ".notify");
    return options;
  }

  ChildProcess::Options firmware_options() const {
    const auto config = base::find_config("firmware/quad_x.parm").parent_path().parent_path();
    const std::map<std::string, std::string> own{{"CAS_FCU_TTY", places_.firmware_tty().string()},
                                                 {"CAS_CONFIG", config.string()}};
    const auto text = [&own](const std::string& written) { return with_variables(written, own); };
    std::vector<std::string> arguments;
    for (const std::string& word : scenario_.firmware.command) arguments.push_back(text(word));
    ChildProcess::Options options = this->options("firmware", arguments);
    options.says_ready = false;
    options.cwd = scenario_.firmware.cwd.empty()
                      ? places_.run / "firmware"
                      : std::filesystem::path(text(scenario_.firmware.cwd));
    std::filesystem::create_directories(options.cwd);
    for (const auto& [name, value] : scenario_.firmware.environment) {
      options.environment.push_back(name + "=" + text(value));
    }
    return options;
  }

  const FirmwareScenario& scenario_;
  const FirmwarePlaces& places_;
  Supervisor supervisor_;
  std::optional<PtyCable> cable_;
  ChildProcess* casd_ = nullptr;
  ChildProcess* hilsim_ = nullptr;
  ChildProcess* firmware_ = nullptr;
};

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

Json rms_json(const RmsFigures& rms) {
  return {{"x_m", rms.x_m}, {"y_m", rms.y_m}, {"z_m", rms.z_m}, {"yaw_rad", rms.yaw_rad}};
}

Json summary(const FirmwareScenario& scenario, const FirmwareFigures& figures,
             const Verdict& verdict) {
  Json json{{"schema", 1},
            {"scenario", scenario.name},
            {"firmware", figures.version},
            {"passed", verdict.passed},
            {"missed", verdict.failures},
            {"height_error_m", figures.height_error_m},
            {"drift_m", figures.drift_m},
            {"simulated_s", figures.simulated_s},
            {"wall_s", figures.wall_s},
            {"real_time_factor", figures.real_time_factor},
            {"dropped", figures.dropped},
            {"lost", figures.lost},
            {"messages", Json::parse(figures.messages)},
            {"hops_us", Json::parse(figures.hops)},
            {"rates_hz", figures.rates_hz},
            {"faults", Json::array()},
            {"incidents", Json::array()},
            {"stages", Json::array()}};
  if (figures.rms) json["rms"] = rms_json(*figures.rms);
  if (figures.rms_estimate) json["rms_estimate"] = rms_json(*figures.rms_estimate);
  for (const BenchFaultScript::Span& fault : figures.faults) {
    Json& entry = json["faults"].emplace_back();
    entry = {{"name", fault.name}, {"begin_s", base::to_seconds(fault.begin)}};
    if (fault.end) entry["end_s"] = base::to_seconds(*fault.end);
  }
  for (const Incident& incident : figures.incidents) {
    json["incidents"].push_back(
        {{"kind", to_string(incident.kind)}, {"time_s", incident.time_s}, {"what", incident.what}});
  }
  for (const Stage& stage : figures.stages) {
    json["stages"].push_back({{"step", to_string(stage.step.kind)},
                              {"begin_s", base::to_seconds(stage.begin)},
                              {"end_s", base::to_seconds(stage.end)}});
  }
  return json;
}

/// About the mean of the measured hold: where a stock estimator's origin lies is not known so well.
std::optional<RmsFigures> rms_of_hold(const std::vector<Stage>& stages,
                                      std::span<const PoseSample> truth) {
  for (const Stage& stage : stages) {
    if (!stage.step.measure) continue;
    const auto held = between(truth, microseconds(stage.begin), microseconds(stage.end));
    if (held.empty()) return std::nullopt;
    Pose mean;
    double sines = 0;
    double cosines = 0;
    const auto count = static_cast<double>(held.size());
    for (const PoseSample& sample : held) {
      mean.x_m += sample.pose.x_m / count;
      mean.y_m += sample.pose.y_m / count;
      mean.z_m += sample.pose.z_m / count;
      sines += std::sin(sample.pose.yaw_rad);
      cosines += std::cos(sample.pose.yaw_rad);
    }
    mean.yaw_rad = std::atan2(sines, cosines);
    return rms_about(held, [&mean](std::int64_t) { return mean; });
  }
  return std::nullopt;
}

LimitCheck check(const char* what, const std::string& wanted, const std::string& missed) {
  return {.what = what,
          .found = missed.empty() ? wanted : missed,
          .wanted = wanted,
          .kept = missed.empty(),
          .sentence = missed};
}

/// A figure of the measured hold. @param bounded  its name, unit, digits, sense and bound
LimitCheck check(LimitCheck bounded, std::optional<double> value) {
  bounded.value = value;
  const std::optional<double> margin = bounded.margin();
  bounded.kept = margin && *margin >= 0;
  if (!margin) {
    bounded.sentence = fmt::format("{} was not measured: the hold was not reached", bounded.what);
  } else if (!bounded.kept) {
    bounded.sentence = fmt::format("{0} {1:.{4}f} {3}, limit {2:.{4}f} {3}", bounded.what, *value,
                                   *bounded.bound, bounded.unit, bounded.digits);
  }
  return bounded;
}

/// What a scenario asks of links and messages.
void check_links(const FirmwareScenario& scenario, const FirmwareFigures& figures,
                 std::vector<LimitCheck>& checks) {
  if (scenario.hop_p99_us) {
    checks.push_back(check({.what = "slowest way through casd, 99 %",
                            .unit = "us",
                            .digits = 0,
                            .bound = scenario.hop_p99_us},
                           slowest_hop_us(Json::parse(figures.hops))));
  }
  for (const auto& [name, least_hz] : scenario.rates_hz) {
    std::optional<double> rate;
    if (!figures.rates_hz.empty()) {
      const auto found = figures.rates_hz.find(name);
      rate = found == figures.rates_hz.end() ? 0 : found->second;
    }
    checks.push_back(check({.what = "rate of " + name,
                            .unit = "Hz",
                            .digits = 1,
                            .sense = LimitCheck::Sense::kAtLeast,
                            .bound = least_hz},
                           rate));
  }
}

/// A flight without a replay keeps its verdict.
void leave_replay(const std::filesystem::path& out) {
  try {
    const auto file = write_replay(out, tlog_record(out / "flight.tlog"));
    fmt::print("Replay:  {}\n", file.empty() ? std::string(why_no_page()) : file.string());
  } catch (const std::exception& error) {
    fmt::print(stderr, "hils: the replay was not written: {}\n", error.what());
  }
}

}  // namespace

void add_truth(const std::filesystem::path& truth, FirmwareFigures& figures) {
  try {
    const std::vector<PoseSample> samples = read_truth(truth);
    if (samples.empty()) {
      figures.unwatched = truth.string() + " is empty";
    } else {
      figures.incidents = find_incidents(figures.stages, samples);
      figures.rms = rms_of_hold(figures.stages, samples);
    }
  } catch (const base::ConfigError& error) {
    figures.unwatched = error.what();
  }
}

void add_estimate(const std::filesystem::path& truth, const std::filesystem::path& tlog,
                  FirmwareFigures& figures) {
  try {
    const std::vector<PoseSample> estimate = read_estimate(tlog, figures.system, figures.log_clock);
    figures.rms_estimate = estimate_error(figures.stages, read_truth(truth), estimate);
  } catch (const base::ConfigError&) {
    figures.rms_estimate.reset();  // a limit on it is missed
  }
}

std::optional<RmsFigures> estimate_error(const std::vector<Stage>& stages,
                                         std::span<const PoseSample> truth,
                                         std::span<const PoseSample> estimate) {
  const auto takeoff = std::ranges::find(stages, StepKind::kTakeoff,
                                         [](const Stage& stage) { return stage.step.kind; });
  const auto hold = std::ranges::find_if(stages, [](const Stage& s) { return s.step.measure; });
  if (takeoff == stages.end() || hold == stages.end() || truth.empty()) return std::nullopt;
  const auto true_at = [truth](std::int64_t time_us) {
    const auto next = std::ranges::lower_bound(truth, time_us, {}, &PoseSample::time_us);
    return next == truth.end() ? truth.back().pose : next->pose;
  };
  const std::int64_t off_us = microseconds(takeoff->begin);
  const auto standing = between(estimate, off_us - 1'000'000, off_us);
  const auto held = between(estimate, microseconds(hold->begin), microseconds(hold->end));
  if (standing.empty() || held.empty()) return std::nullopt;
  Pose origin;
  const auto count = static_cast<double>(standing.size());
  for (const PoseSample& sample : standing) {
    const Pose pose = true_at(sample.time_us);
    origin.x_m += (sample.pose.x_m - pose.x_m) / count;
    origin.y_m += (sample.pose.y_m - pose.y_m) / count;
    origin.z_m += (sample.pose.z_m - pose.z_m) / count;
  }
  return rms_about(held, [&](std::int64_t time_us) {
    Pose pose = true_at(time_us);
    pose.x_m += origin.x_m;
    pose.y_m += origin.y_m;
    pose.z_m += origin.z_m;
    return pose;
  });
}

std::optional<double> slowest_hop_us(const Json& hops) {
  std::optional<double> slowest;
  for (const Json& link : hops) {
    for (const Json& route : link.value("routes", Json::array())) {
      slowest = std::max(slowest.value_or(0), route.value("p99", 0.0));
    }
  }
  return slowest;
}

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

void add_losses(const Json& links, FirmwareFigures& figures) {
  for (const Json& link : links) {
    for (const Json& count : link.at("tx").at("dropped")) {
      figures.dropped += count.get<std::uint64_t>();
    }
    figures.lost += link.at("rx").at("lost").get<std::uint64_t>();
  }
}

Verdict judge(const FirmwareScenario& scenario, const FirmwareFigures& figures) {
  Verdict verdict;
  verdict.valid = true;
  std::vector<LimitCheck>& checks = verdict.checks;
  const auto measured = [&figures](double value) {
    return figures.looks > 0 ? std::optional(value) : std::nullopt;
  };
  checks.push_back(check("flight", "every step was done", figures.flight_failure));
  if (scenario.height_error_m) {
    checks.push_back(
        check({.what = "height error", .unit = "m", .digits = 2, .bound = scenario.height_error_m},
              measured(figures.height_error_m)));
  }
  if (scenario.drift_m) {
    checks.push_back(check({.what = "drift", .unit = "m", .digits = 2, .bound = scenario.drift_m},
                           measured(figures.drift_m)));
  }
  check_rms("true position", figures.rms, scenario.rms, checks);
  check_rms("estimate", figures.rms_estimate, scenario.rms_estimate, checks);
  check_links(scenario, figures, checks);
  std::string incidents;
  for (const Incident& incident : figures.incidents) {
    incidents += (incidents.empty() ? "the vehicle " : "; it ") + incident.what;
  }
  checks.push_back(check("incidents", "none", incidents));
  checks.push_back(check(
      "true flight", "recorded",
      figures.unwatched.empty() ? "" : "the true flight was not recorded: " + figures.unwatched));
  for (const LimitCheck& each : checks) {
    if (!each.kept) verdict.failures.push_back(each.sentence);
  }
  verdict.passed = verdict.failures.empty();
  return verdict;
}

int fly_firmware(const FirmwareScenario& scenario, const std::filesystem::path& out) {
  remove_verdict(out);
  const RunDirectory sockets;
  const FirmwarePlaces places{.out = out,
                              .run = out / "run",
                              .sockets = sockets.path(),
                              .command_port = sockets.command_socket()};
  write_firmware_configs(scenario, places);
  FirmwareBench bench(scenario, places);
  const base::RunTime begin = base::steady_now();
  FirmwareFigures figures;
  try {
    bench.start();
    figures = FirmwarePilot(scenario, places, bench.supervisor()).fly();
  } catch (const base::rpc::ConnectionError& error) {
    bench.supervisor().wait(std::chrono::milliseconds(500));  // a program that died is noticed
    throw RunStopped(std::string("a control connection failed: ") + error.what(), false);
  } catch (const RunStopped& stopped) {
    const std::string& hint = scenario.firmware.hint;
    const bool of_firmware = std::string_view(stopped.what()).starts_with("firmware ");
    if (!of_firmware || hint.empty()) throw;
    throw RunStopped(std::string(stopped.what()) + "\n" + hint, false);
  }
  bench.stop();
  figures.wall_s = base::to_seconds(base::steady_now() - begin);
  add_truth(places.truth_csv(), figures);
  add_estimate(places.truth_csv(), places.flight_tlog(), figures);
  figures.faults = vehicle_faults(places.simulator_stats(), scenario.vehicle);

  const Verdict verdict = judge(scenario, figures);
  base::write_file(out / "summary.json", summary(scenario, figures, verdict).dump(2) + "\n",
                   base::Durability::kCache);
  base::write_file(out / "junit.xml",
                   junit_report("hils." + scenario.name, figures.wall_s, verdict),
                   base::Durability::kCache);
  base::write_file(out / "report.html", firmware_report(scenario, places, figures, verdict),
                   base::Durability::kCache);
  fmt::print("{}: {}{}\n", verdict_word(verdict), scenario.name,
             figures.version.empty() ? "" : ", firmware v" + figures.version);
  for (const std::string& sentence : verdict.failures) fmt::print("  - {}\n", sentence);
  fmt::print("  {:.1f} s simulated at {:.2f} x real time; height error {:.2f} m, drift {:.2f} m\n",
             figures.simulated_s, figures.real_time_factor, figures.height_error_m,
             figures.drift_m);
  if (const auto& rms = figures.rms) {
    fmt::print("  RMS of the true position about its mean: {:.3f}, {:.3f}, {:.3f} m\n", rms->x_m,
               rms->y_m, rms->z_m);
  }
  if (const auto& rms = figures.rms_estimate) {
    fmt::print("  RMS of the estimate against the truth: {:.3f}, {:.3f}, {:.3f} m, {:.4f} rad\n",
               rms->x_m, rms->y_m, rms->z_m, rms->yaw_rad);
  }
  fmt::print(
      "  casd dropped {} packets and missed {} by their numbers; not judged, nor is the pace\n",
      figures.dropped, figures.lost);
  if (const std::uint64_t lost = bench.lost_bytes(); lost > 0) {
    fmt::print("  the serial line lost {} bytes that were not read in time\n", lost);
  }
  fmt::print("Results: {}\n", out.string());
  std::fflush(stdout);
  leave_replay(out);
  return verdict.exit_code();
}

}  // namespace cas::hils
