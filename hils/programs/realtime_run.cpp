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
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "base/config/config_keys.hpp"
#include "base/rpc/client.hpp"
#include "base/time/clock.hpp"
#include "base/time/unix_time.hpp"
#include "fcu/line/line_keys.hpp"
#include "hils/flight/bench_fault.hpp"
#include "hils/flight/flight_loop.hpp"
#include "hils/measure/run_record.hpp"
#include "hils/programs/bench_programs.hpp"
#include "hils/programs/composition.hpp"
#include "hils/programs/cpu_pressure.hpp"
#include "hils/programs/fcu_device.hpp"
#include "hils/programs/flown_simulator.hpp"
#include "hils/programs/ground_station.hpp"
#include "hils/programs/live_run.hpp"
#include "hils/programs/page_watch.hpp"
#include "hils/programs/pilot_calls.hpp"
#include "hils/programs/progress.hpp"
#include "hils/programs/scenario_flight.hpp"
#include "hils/programs/supervisor.hpp"
#include "hils/run/run_paths.hpp"

namespace cas::hils {

namespace {

using base::rpc::Json;
using std::chrono::seconds;

constexpr base::Duration kStreamLook = seconds(1);

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

/// The programs of a run in real time: flown over the control connections of simulator and casd.
class RealtimeBench final : public FlightBench {
 public:
  /// @param ground_station  nothing where the run has none
  RealtimeBench(Supervisor& supervisor, BenchPrograms& programs, const RunPaths& paths,
                const RunRequest& request, GroundStationThread* ground_station)
      : supervisor_(supervisor),
        programs_(programs),
        paths_(paths),
        ground_station_(ground_station),
        live_(request.live),
        simulator_(paths.simulator_control()),
        casd_(connect(address(paths.command_port))),
        line_(line_of(request)),
        watch_(request.live, simulator_, [this] { return casd_ ? &*casd_ : nullptr; }) {
    systems_ = request.scenario.systems();
    for (const std::uint8_t system : systems_) {
      asked_.push_back(request.scenario.flies_several() ? AskedVehicle(system) : std::nullopt);
    }
  }

  base::SimTime look() override {
    const base::SimTime now = simulator_.look();
    log_clock_.add(base::unix_us(), to_microseconds(now));
    return now;
  }

  Motion truth(std::size_t vehicle) const override { return simulator_.status().truth.at(vehicle); }

  std::optional<VehicleReport> report(std::size_t vehicle) override {
    return casd_ ? vehicle_report(*casd_, asked_[vehicle]) : VehicleReport{};
  }

  void before_steps(Flight&, base::SimTime) override { watch_.before_steps(); }

  void after_steps(Flight& flight, base::SimTime now) override {
    watch_.after_steps(flight, now, [&](const BenchFault& fault) { play(flight, fault, true); });
    watch_machine(flight);
  }

  void tell_phase(std::string_view phase) override { simulator_.tell_phase(phase); }

  void play(const Flight& flight, const BenchFault& fault, bool begins) override {
    const VehiclePaths& vehicle = paths_.vehicles[fault.vehicle];
    if (const auto* line = std::get_if<LineFault>(&fault.kind)) {
      base::rpc::Client fcu(address(vehicle.fcu_control()));
      if (!begins) line = flight.faults.line_of(fault.vehicle);  // another one may go on
      fcu.call("line.set", to_json(line == nullptr ? line_ : line->line));
    } else if (std::holds_alternative<UnplugFault>(fault.kind)) {
      if (!begins) return;  // the emulator plugs itself in again
      base::rpc::Client fcu(address(vehicle.fcu_control()));
      fcu.call("line.hangup", {{"ms", 1e3 * base::to_seconds(fault.lasting)}});
    } else if (std::holds_alternative<RestartFault>(fault.kind)) {
      if (begins) watch_.before_casd_ends();
      casd_.reset();
      if (begins) return programs_.kill_casd();
      programs_.start_casd();
      casd_.emplace(connect(address(paths_.command_port)));
    } else if (const auto* flood = std::get_if<FloodFault>(&fault.kind)) {
      if (ground_station_ == nullptr) return;
      ground_station_->with_station(
          [&](GroundStation& station) { station.flood(begins ? flood->packets_hz : 0); });
    } else if (std::holds_alternative<SilenceFault>(fault.kind)) {
      if (ground_station_ == nullptr) return;
      ground_station_->with_station([&](GroundStation& station) { station.lose_sticks(begins); });
    } else if (std::holds_alternative<ReloadFault>(fault.kind)) {
      if (begins && casd_) casd_->call("casd.reload", Json::object());
    }
  }

  void show(base::SimTime now, const FlightPlan& plan, const VehicleReport& vehicle) override {
    watch_stream();
    const FlownSimulator::Status& status = simulator_.status();
    progress_.show(now, plan, vehicle, pace_words(status.real_time_factor, status.late_steps),
                   stream_);
  }

  void give(Flight&, std::size_t vehicle, const FlightStep& step, Answer answer) override {
    if (const auto sticks = held_sticks(step)) {
      const std::uint8_t system = systems_[vehicle];
      ground_station_->with_station([&](GroundStation& station) { station.hold(system, *sticks); });
    }
    const std::optional<Refusal> refusal =
        casd_ ? hils::give(*casd_, step, false, asked_[vehicle]) : Refusal{"casd is away"};
    answer(simulator_.look(), refusal);
  }

  /// The flight is over. @param records  of the vehicles, which it fills in
  void finish(const Flight& flight, std::vector<RunRecord>& records) {
    if (live_ != nullptr) live_->end_flight();
    supervisor_.wait(kDrain);
    const base::SimTime now = simulator_.look();
    const std::vector<OutsideCall> calls = watch_.finish();
    for (std::size_t i = 0; i < records.size(); ++i) {
      record_flight(flight, i, now, records[i]);
      records[i].log_clock = log_clock_;
      records[i].outside_calls = calls;
      records[i].cpu_pressure = pressure_.share();
    }
  }

 private:
  /// Once a second, and only when standard error is a terminal.
  void watch_stream() {
    const base::RunTime now = base::steady_now();
    if (!progress_.shows() || !casd_ || now < next_stream_look_) return;
    next_stream_look_ = now + kStreamLook;
    stream_ = stream_words(casd_->call("casd.status", Json::object()),
                           casd_->call("message.list", Json::object()));
  }

  /// Looks at the machine's load during the measured step.
  void watch_machine(const Flight& flight) {
    const FlightStep* step = flight.plan.plan(flight.plan.leader()).current();
    const bool measuring = step != nullptr && step->measure;
    if (measuring && !measuring_) pressure_.start();
    if (!measuring && measuring_) pressure_.stop();
    measuring_ = measuring;
  }

  Supervisor& supervisor_;
  BenchPrograms& programs_;
  const RunPaths& paths_;
  GroundStationThread* ground_station_;
  LiveRun* live_;  ///< nullptr without a page
  FlownSimulator simulator_;
  std::optional<base::rpc::Client> casd_;  ///< nothing while casd is away
  fcu::LineConfig line_;                   ///< as it is without faults
  std::vector<std::uint8_t> systems_;
  std::vector<AskedVehicle> asked_;  ///< how casd is to name each vehicle
  PageWatch watch_;
  ClockMap log_clock_;
  Progress progress_;
  CpuPressure pressure_;
  std::string stream_;  ///< rates and drops in words, for the terminal
  base::RunTime next_stream_look_{};
  bool measuring_ = false;
};

/// Empty when a fault kills casd: its ledger is lost with it.
std::map<std::string, casd::LinkLedger> read_relay_ledgers(const RunPaths& paths,
                                                           const Scenario& scenario) {
  for (const BenchFault& fault : scenario.faults.bench) {
    if (std::holds_alternative<RestartFault>(fault.kind)) return {};
  }
  return casd::read_link_ledgers(paths.casd_ledger());
}

void add_relay(std::map<std::string, casd::LinkLedger>& ledgers, const VehiclePaths& paths,
               RunRecord& record) {
  const auto simulator = ledgers.find(paths.simulator_link);
  const auto controller = ledgers.find(paths.controller_link);
  if (simulator == ledgers.end() || controller == ledgers.end()) return;
  record.relay = RelayLedgers{.simulator = std::move(simulator->second),
                              .controller = std::move(controller->second)};
}

/// @throws base::ConfigError
void refuse_virtual_faults(const RunRequest& request) {
  for (const BenchFault& fault : request.scenario.faults.bench) {
    const auto* silence = std::get_if<SilenceFault>(&fault.kind);
    const bool silences_ground = silence != nullptr && !silence->sticks;
    if (!silences_ground && !std::holds_alternative<StarveFault>(fault.kind)) continue;
    throw base::ConfigError(
        "fault '" + fault.name +
        "': silence: ground and starve are faults of the virtual clock (--virtual)");
  }
}

/// Reads the ledgers that the programs wrote when they ended.
void read_ledgers(const RunRequest& request, const RunPaths& paths,
                  std::vector<RunRecord>& records) {
  auto relay = read_relay_ledgers(paths, request.scenario);
  for (std::size_t i = 0; i < records.size(); ++i) {
    const VehiclePaths& vehicle = paths.vehicles[i];
    records[i].simulator = base::PacketLedger::read(vehicle.simulator_ledger());
    add_simulator_report(paths, records[i]);
    add_relay(relay, vehicle, records[i]);
    if (request.fcu_device(i) == nullptr) {
      records[i].controller = base::PacketLedger::read(vehicle.controller_ledger());
    } else {
      stand_in_for_controller(paths, vehicle, records[i]);
    }
  }
}

/// Where everything of the run lies. @param ground_station  nullptr: the run has none
RunPaths paths_of(const RunRequest& request, const RunDirectory& sockets,
                  const GroundStationThread* ground_station) {
  RunPaths paths = RunPaths::of(request.scenario, request.out, sockets.path());
  paths.command_port = sockets.command_socket();
  paths.choose_ports();
  if (ground_station != nullptr) paths.ground_station_port = ground_station->port();
  return paths;
}

/// Flies with programs that run. @throws RunStopped
void fly_with(Supervisor& supervisor, BenchPrograms& programs, const RunPaths& paths,
              const RunRequest& request, GroundStationThread* ground_station,
              std::vector<RunRecord>& records) {
  try {
    check_devices(supervisor, paths, request);
    RealtimeBench bench(supervisor, programs, paths, request, ground_station);
    FlightLoop loop(flight_of(request.scenario), bench);
    loop.fly([&supervisor](bool commanded) {
      if (!commanded) supervisor.wait(FlightPlan::kLookPeriod);
    });
    bench.finish(loop.flight(), records);
  } catch (const base::rpc::ConnectionError& error) {
    supervisor.wait(
        std::chrono::milliseconds(500));  // a program that died is noticed within this time
    throw RunStopped(std::string("a control connection failed: ") + error.what(), false);
  }
}

std::vector<RunRecord> fly_in_real_time(const RunRequest& request) {
  refuse_emulator_faults(request);
  refuse_virtual_faults(request);
  const base::RunTime begin = base::steady_now();
  const RunDirectory sockets;
  Supervisor supervisor;  // before any thread: it blocks signals for all of them
  std::optional<GroundStationThread> ground_station;
  if (request.scenario.ground_station) ground_station.emplace(request.scenario.systems());
  GroundStationThread* const station = ground_station ? &*ground_station : nullptr;
  const RunPaths paths = paths_of(request, sockets, station);
  write_configs(request, Transport::kUdp, paths);

  std::vector<RunRecord> records = records_of(request.scenario, paths);
  BenchPrograms programs(supervisor, paths, request);
  programs.start();
  if (request.live != nullptr) request.live->start(request, paths, supervisor);
  fly_with(supervisor, programs, paths, request, station, records);
  programs.stop();
  const double wall_s = base::to_seconds(base::steady_now() - begin);
  for (RunRecord& record : records) {
    record.wall_s = wall_s;
    record.cpu_s = supervisor.cpu_s();
  }
  read_ledgers(request, paths, records);
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
