// SPDX-License-Identifier: BSD-3-Clause
#include "hils/programs/realtime_run.hpp"

#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <exception>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "base/config/config_keys.hpp"
#include "base/rpc/client.hpp"
#include "base/time/clock.hpp"
#include "base/time/unix_time.hpp"
#include "fcu/line/line_keys.hpp"
#include "hils/flight/bench_fault.hpp"
#include "hils/measure/run_record.hpp"
#include "hils/programs/bench_programs.hpp"
#include "hils/programs/composition.hpp"
#include "hils/programs/cpu_pressure.hpp"
#include "hils/programs/fcu_device.hpp"
#include "hils/programs/ground_station.hpp"
#include "hils/programs/live_run.hpp"
#include "hils/programs/pilot_calls.hpp"
#include "hils/programs/progress.hpp"
#include "hils/programs/supervisor.hpp"
#include "hils/run/run_places.hpp"
#include "hils/scenario/fleet_plan.hpp"

namespace cas::hils {

namespace {

using base::rpc::Json;
using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr base::Duration kPollPeriod = milliseconds(50);
constexpr base::Duration kStreamLook = seconds(1);
/// The stream goes on for this long after the flight, so that the pipe is drained.
constexpr base::Duration kDrain = seconds(1);

Json to_json(const fcu::LineConfig& line) {
  Json json;
  base::for_each_key(fcu::kLineKeys, [&](const auto& key) {
    const auto& value = key.of(line);
    if constexpr (requires { key.kind.number(value); }) {
      json[std::string(key.name)] = key.kind.number(value);
    } else {
      json[std::string(key.name)] = value;
    }
  });
  return json;
}

/// "up 500 + 5, down 400 Hz, 0 dropped".
std::string stream_words(const Json& status, const Json& messages) {
  double sensor = 0, gps = 0, controls = 0, dropped = 0;
  for (const Json& message : messages) {
    if (!message.is_object() || message.value("direction", "") != "tx") continue;
    const std::string name = message.value("name", "");
    const double hz = message.value("hz", 0.0);
    if (name == "HIL_SENSOR") sensor += hz;
    if (name == "HIL_GPS") gps += hz;
    if (name == "HIL_CONTROLS" || name == "HIL_ACTUATOR_CONTROLS") controls += hz;
  }
  for (const Json& link : status.value("links", Json::array())) {
    const Json tx = link.value("tx", Json::object());
    for (const Json& count : tx.value("dropped", Json::object())) dropped += count.get<double>();
  }
  return fmt::format("up {:.0f} + {:.0f}, down {:.0f} Hz, {:.0f} dropped", sensor, gps, controls,
                     dropped);
}

std::string address(const std::filesystem::path& socket) { return "unix:" + socket.string(); }

/// Flies the vehicles of a scenario in real time over the control connections of simulator and
/// casd, and plays the faults of the bench.
class RealtimePilot {
 public:
  /// @param ground_station  nothing where the run has none
  RealtimePilot(Supervisor& supervisor, BenchPrograms& programs, const RunPlaces& places,
                const RunRequest& request, GroundStationThread* ground_station);

  /// To the end of the plan, or until it fails. @throws RunStopped, base::rpc::ConnectionError
  /// @param records  of the vehicles, which it fills in
  void fly(std::vector<RunRecord>& records);

 private:
  base::SimTime simulated_time();
  void look();
  std::optional<Refusal> give(const FleetPlan::Command& command);
  void show(base::SimTime now);
  void watch_pause();
  void play_faults(base::SimTime now);
  void play(const BenchFault& fault, bool begins);
  void keep_outside_calls();
  std::vector<OutsideCall> calls_of_others();
  void show_page(base::SimTime now);
  void fill(std::vector<RunRecord>& records, const ClockMap& log_clock);
  void watch_machine();
  void watch_stream();

  Supervisor& supervisor_;
  BenchPrograms& programs_;
  const RunPlaces& places_;
  GroundStationThread* ground_station_;
  LiveRun* live_;  ///< nullptr without a page
  base::rpc::Client simulator_;
  std::optional<base::rpc::Client> casd_;   ///< nothing while casd is away
  fcu::LineConfig line_;                    ///< as it is without faults
  std::vector<AskedVehicle> asked_;         ///< how casd is to name each vehicle
  std::vector<OutsideCall> outside_calls_;  ///< by others, to casds that have ended
  FleetPlan plan_;
  BenchFaultScript faults_;
  Progress progress_;
  CpuPressure pressure_;
  std::string phase_;
  std::string stream_;  ///< rates and drops in words, for the terminal
  base::RunTime next_stream_look_{};
  bool measuring_ = false;
  double real_time_factor_ = 0;
  std::uint64_t late_steps_ = 0;
  bool paused_ = false;
  bool said_paused_ = false;
  std::vector<VehicleReport> vehicles_;
  std::vector<Eigen::Vector3d> start_m_;  ///< where they stood when the run began
};

RealtimePilot::RealtimePilot(Supervisor& supervisor, BenchPrograms& programs,
                             const RunPlaces& places, const RunRequest& request,
                             GroundStationThread* ground_station)
    : supervisor_(supervisor),
      programs_(programs),
      places_(places),
      ground_station_(ground_station),
      live_(request.live),
      simulator_(connect(address(places.simulator_control()))),
      casd_(connect(address(places.command_port))),
      line_(line_of(request)),
      plan_(request.scenario),
      faults_(request.scenario.faults.bench),
      vehicles_(request.scenario.vehicles.size()) {
  for (const std::uint8_t system : request.scenario.systems()) {
    asked_.push_back(request.scenario.flies_several() ? AskedVehicle(system) : std::nullopt);
  }
}

void RealtimePilot::fly(std::vector<RunRecord>& records) {
  ClockMap log_clock;
  while (true) {
    const base::SimTime now = simulated_time();
    log_clock.add(base::unix_us(), to_microseconds(now));
    look();
    watch_pause();
    const std::vector<FleetPlan::Command> commands = plan_.update(now, vehicles_);
    send_phase(simulator_, plan_.phase(), phase_);
    show_page(now);
    play_faults(now);
    watch_machine();
    if (plan_.ended()) break;
    show(now);
    for (const FleetPlan::Command& command : commands) {
      if (plan_.ended()) break;
      const std::optional<Refusal> refusal = give(command);
      plan_.on_outcome(command.vehicle, simulated_time(), refusal);
    }
    if (commands.empty()) supervisor_.wait(kPollPeriod);
  }
  if (live_ != nullptr) live_->end_flight();
  supervisor_.wait(kDrain);
  fill(records, log_clock);
}

void RealtimePilot::keep_outside_calls() {
  if (!casd_) return;
  const std::vector<OutsideCall> calls = read_outside_calls(*casd_);
  outside_calls_.insert(outside_calls_.end(), calls.begin(), calls.end());
}

/// Up to now, at casd, the simulator and the page.
std::vector<OutsideCall> RealtimePilot::calls_of_others() {
  std::vector<OutsideCall> calls = outside_calls_;
  const auto add = [&calls](const std::vector<OutsideCall>& more) {
    calls.insert(calls.end(), more.begin(), more.end());
  };
  if (casd_) add(read_outside_calls(*casd_));
  add(read_simulator_calls(simulator_));
  if (live_ != nullptr) add(live_->calls());
  return calls;
}

/// With a page: sends the figures that it shows, and takes the faults that it orders.
void RealtimePilot::show_page(base::SimTime now) {
  if (live_ == nullptr || plan_.ended()) return;
  if (live_->wants_calls()) live_->show_calls(calls_of_others());
  live_->look(now, plan_, vehicles_, start_m_);
  live_->play_faults(now, vehicles_, faults_, simulator_,
                     [this](const BenchFault& fault) { play(fault, true); });
}

void RealtimePilot::fill(std::vector<RunRecord>& records, const ClockMap& log_clock) {
  const base::SimTime now = simulated_time();
  const std::vector<OutsideCall> calls = calls_of_others();
  if (live_ != nullptr) live_->show_calls(calls);
  for (std::size_t i = 0; i < records.size(); ++i) {
    RunRecord& record = records[i];
    record.log_clock = log_clock;
    record.simulated_s = base::to_seconds(now);
    record.flight_failure = plan_.failure_of(i);
    record.stages = plan_.plan(i).stages();
    record.under_way = plan_.plan(i).under_way(now);
    record.hold = plan_.plan(i).measured();
    record.faults = faults_.history_of(i);
    record.outside_calls = calls;
    record.cpu_pressure = pressure_.share();
  }
}

base::SimTime RealtimePilot::simulated_time() {
  const Json status = simulator_.call("sim.status", Json::object());
  real_time_factor_ = status.value("real_time_factor", 0.0);
  late_steps_ = status.value("late_steps", std::uint64_t{0});
  paused_ = status.value("paused", false);
  for (std::size_t i = 0; i < vehicles_.size(); ++i) {
    Motion truth = to_motion(status.at("vehicles").at(i));
    if (i == start_m_.size()) start_m_.push_back(truth.p_m);
    truth.p_m -= start_m_[i];
    vehicles_[i].truth = truth;
  }
  return base::SimTime(base::from_seconds(status.at("time_s").get<double>()));
}

void RealtimePilot::look() {
  for (std::size_t i = 0; i < vehicles_.size(); ++i) {
    VehicleReport report;
    if (casd_) report = vehicle_report(*casd_, asked_[i]);
    report.truth = vehicles_[i].truth;
    vehicles_[i] = plan_.plan(i).from_arming(std::move(report));
  }
}

void RealtimePilot::show(base::SimTime now) {
  watch_stream();
  const std::size_t leader = plan_.leader();
  progress_.show(now, plan_.plan(leader), vehicles_[leader],
                 pace_words(real_time_factor_, late_steps_), stream_);
}

/// @return why the vehicle refused, or nothing
std::optional<Refusal> RealtimePilot::give(const FleetPlan::Command& command) {
  if (!casd_) return Refusal{"casd is away"};
  return hils::give(*casd_, command.step, false, asked_[command.vehicle]);
}

/// A paused run waits for ever: names the caller, and resumes the run if casweb has ended
/// meanwhile.
void RealtimePilot::watch_pause() {
  if (!paused_) {
    said_paused_ = false;
    return;
  }
  if (!said_paused_) {
    said_paused_ = true;
    std::string who = "somebody";
    for (const OutsideCall& call : read_simulator_calls(simulator_)) {
      if (call.method == "sim.pause") who = call.client;
    }
    fmt::print(stderr, "hils: paused by {}: the run waits for `sim.resume`\n", who);
  }
  if (live_ == nullptr || !live_->page_has_ended()) return;
  fmt::print(stderr, "hils: casweb has ended, so the page cannot resume the run: it goes on\n");
  live_->resume(simulator_);
}

void RealtimePilot::play_faults(base::SimTime now) {
  for (const auto& [fault, begins] : faults_.update(now, vehicles_, plan_.phase())) {
    play(*fault, begins);
  }
}

void RealtimePilot::play(const BenchFault& fault, bool begins) {
  const VehiclePlaces& vehicle = places_.vehicles[fault.vehicle];
  if (const auto* line = std::get_if<LineFault>(&fault.kind)) {
    base::rpc::Client fcu(address(vehicle.fcu_control()));
    if (!begins) line = faults_.line_of(fault.vehicle);  // another one may go on
    fcu.call("line.set", to_json(line == nullptr ? line_ : line->line));
  } else if (std::holds_alternative<UnplugFault>(fault.kind)) {
    if (!begins) return;  // the emulator plugs itself in again
    base::rpc::Client fcu(address(vehicle.fcu_control()));
    fcu.call("line.hangup", {{"ms", 1e3 * base::to_seconds(fault.lasting)}});
  } else if (std::holds_alternative<RestartFault>(fault.kind)) {
    if (begins) keep_outside_calls();  // casd's journal ends with it
    casd_.reset();
    if (begins) return programs_.kill_casd();
    programs_.start_casd();
    casd_.emplace(connect(address(places_.command_port)));
  } else if (const auto* flood = std::get_if<FloodFault>(&fault.kind)) {
    if (ground_station_ != nullptr) ground_station_->flood(begins ? flood->packets_hz : 0);
  } else if (std::holds_alternative<ReloadFault>(fault.kind)) {
    if (begins && casd_) casd_->call("casd.reload", Json::object());
  }
}

/// Once a second, and only when standard error is a terminal.
void RealtimePilot::watch_stream() {
  const base::RunTime now = base::steady_now();
  if (!progress_.shows() || !casd_ || now < next_stream_look_) return;
  next_stream_look_ = now + kStreamLook;
  stream_ = stream_words(casd_->call("casd.status", Json::object()),
                         casd_->call("message.list", Json::object()));
}

/// Looks at the machine's load during the measured step.
void RealtimePilot::watch_machine() {
  const FlightStep* step = plan_.plan(plan_.leader()).current();
  const bool measuring = step != nullptr && step->measure;
  if (measuring && !measuring_) pressure_.start();
  if (!measuring && measuring_) pressure_.stop();
  measuring_ = measuring;
}

/// Empty when a fault kills casd: its ledger is lost with it.
std::map<std::string, casd::LinkLedger> read_relay_ledgers(const RunPlaces& places,
                                                           const Scenario& scenario) {
  for (const BenchFault& fault : scenario.faults.bench) {
    if (std::holds_alternative<RestartFault>(fault.kind)) return {};
  }
  return casd::read_link_ledgers(places.casd_ledger());
}

void add_relay(std::map<std::string, casd::LinkLedger>& ledgers, const VehiclePlaces& places,
               RunRecord& record) {
  const auto simulator = ledgers.find(places.simulator_link);
  const auto controller = ledgers.find(places.controller_link);
  if (simulator == ledgers.end() || controller == ledgers.end()) return;
  record.relay = RelayLedgers{.simulator = std::move(simulator->second),
                              .controller = std::move(controller->second)};
}

/// @throws base::ConfigError
void refuse_virtual_faults(const RunRequest& request) {
  for (const BenchFault& fault : request.scenario.faults.bench) {
    const bool silences = std::holds_alternative<SilenceFault>(fault.kind);
    if (!silences && !std::holds_alternative<StarveFault>(fault.kind)) continue;
    throw base::ConfigError("fault '" + fault.name +
                            "': silence and starve are faults of the virtual clock (--virtual)");
  }
}

/// Reads the ledgers that the programs wrote when they ended.
void read_ledgers(const RunRequest& request, const RunPlaces& places,
                  std::vector<RunRecord>& records) {
  auto relay = read_relay_ledgers(places, request.scenario);
  for (std::size_t i = 0; i < records.size(); ++i) {
    const VehiclePlaces& vehicle = places.vehicles[i];
    records[i].simulator = base::PacketLedger::read(vehicle.simulator_ledger());
    add_simulator_report(places, records[i]);
    add_relay(relay, vehicle, records[i]);
    if (request.fcu_device(i) == nullptr) {
      records[i].controller = base::PacketLedger::read(vehicle.controller_ledger());
    } else {
      stand_in_for_controller(places, vehicle, records[i]);
    }
  }
}

std::vector<RunRecord> fly_in_real_time(const RunRequest& request) {
  refuse_emulator_faults(request);
  refuse_virtual_faults(request);
  const base::RunTime begin = base::steady_now();
  const RunDirectory sockets;
  RunPlaces places = RunPlaces::of(request.scenario, request.out, sockets.path());
  places.command_port = sockets.command_socket();
  places.choose_ports();
  Supervisor supervisor;  // before any thread: it blocks signals for all of them
  std::optional<GroundStationThread> ground_station;
  if (request.scenario.ground_station) {
    ground_station.emplace(request.scenario.systems());
    places.ground_station_port = ground_station->port();
  }
  write_configs(request, Transport::kUdp, places);

  std::vector<RunRecord> records = records_of(request.scenario, places);
  BenchPrograms programs(supervisor, places, request);
  programs.start();
  if (request.live != nullptr) request.live->start(request, places, supervisor);
  try {
    check_devices(supervisor, places, request);
    RealtimePilot(supervisor, programs, places, request,
                  ground_station ? &*ground_station : nullptr)
        .fly(records);
  } catch (const base::rpc::ConnectionError& error) {
    supervisor.wait(
        std::chrono::milliseconds(500));  // a program that died is noticed within this time
    throw RunStopped(std::string("a control connection failed: ") + error.what(), false);
  }
  programs.stop();
  const double wall_s = base::to_seconds(base::steady_now() - begin);
  for (RunRecord& record : records) {
    record.wall_s = wall_s;
    record.cpu_s = supervisor.cpu_s();
  }
  read_ledgers(request, places, records);
  return records;
}

}  // namespace

std::vector<RunRecord> run_in_real_time(const RunRequest& request) {
  try {
    return fly_in_real_time(request);
  } catch (const std::exception& error) {
    if (request.live != nullptr) request.live->tell_end(error.what());
    throw;
  }
}

}  // namespace cas::hils
