// SPDX-License-Identifier: BSD-3-Clause
#include "hils/programs/lockstep_run.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <iterator>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "base/os/cpu_latency.hpp"
#include "base/rpc/client.hpp"
#include "base/time/clock.hpp"
#include "casd/tlog/tlog_writer.hpp"
#include "hils/flight/flight_loop.hpp"
#include "hils/programs/bench_programs.hpp"
#include "hils/programs/composition.hpp"
#include "hils/programs/flown_simulator.hpp"
#include "hils/programs/pilot_calls.hpp"
#include "hils/programs/progress.hpp"
#include "hils/programs/scenario_flight.hpp"
#include "hils/programs/supervisor.hpp"
#include "hils/run/run_paths.hpp"
#include "mavlink/common/enums.hpp"
#include "mavlink/common/home_position.hpp"

namespace cas::hils {

namespace {

using base::rpc::Json;
using std::chrono::milliseconds;
using std::chrono::seconds;

/// Until casd has heard the controller, on a machine that may be very busy.
constexpr base::Duration kMeetPatience = seconds(120);

/// The answer of fcu.status as a report.
VehicleReport controller_report(const Json& status) {
  const auto vector = [&](const char* key) {
    Eigen::Vector3d v = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < 3; ++i) {
      const Json& number = status.at(key).at(i);
      if (number.is_number()) v[static_cast<Eigen::Index>(i)] = number.get<double>();
    }
    return v;
  };
  VehicleReport report;
  report.heard = true;
  report.vtol = status.at("vtol").get<std::string>();
  if (status.at("on_wing").get<bool>() && report.vtol.empty()) report.type = "fixed_wing";
  report.armed = status.at("armed").get<bool>();
  const auto landed = status.at("landed").get<std::string>();
  report.in_air = landed == "in_air";
  report.on_ground = landed == "on_ground";
  report.has_position = status.at("estimator_ready").get<bool>();
  report.p_N = vector("p_N_m");
  report.v_N = vector("v_N_m_s");
  const Eigen::Vector3d rpy = vector("rpy_rad");
  report.roll_rad = rpy.x();
  report.pitch_rad = rpy.y();
  report.yaw_rad = rpy.z();
  return report;
}

/// The programs in lockstep: states are read and commands given while simulated time is stopped.
///
///   run_until(next look) -> fcu.status -> plan -> command, acknowledged -> run_until ...
class LockstepBench final : public FlightBench {
 public:
  LockstepBench(Supervisor& supervisor, const RunPaths& paths)
      : supervisor_(supervisor),
        simulator_(paths.simulator_control()),
        controller_("unix:" + paths.vehicles.front().fcu_control().string()),
        casd_(connect("unix:" + paths.command_port.string())) {}

  /// Lets the vehicle say its first words.
  void meet() {
    advance(base::SimTime(FlightPlan::kLookPeriod));
    const base::RunTime deadline = base::steady_now() + kMeetPatience;
    while (!vehicle_report(casd_).heard) {
      if (base::steady_now() > deadline) throw RunStopped("casd never heard the controller", false);
      supervisor_.wait(milliseconds(2));
    }
  }

  void advance(base::SimTime time) {
    supervisor_.check();
    simulator_.run_until(time);
  }

  base::SimTime look() override { return simulator_.status().time; }
  Motion truth(std::size_t vehicle) const override { return simulator_.status().truth.at(vehicle); }
  std::optional<VehicleReport> report(std::size_t) override {
    return controller_report(controller_.call("fcu.status", Json::object()));
  }
  void tell_phase(std::string_view phase) override { simulator_.tell_phase(phase); }
  void play(const Flight&, const BenchFault&, bool) override {}  // refuse_other_clocks()
  void show(base::SimTime now, const FlightPlan& plan, const VehicleReport& vehicle) override {
    progress_.show(now, plan, vehicle, pace_words(simulator_.status().real_time_factor));
  }
  void give(Flight&, std::size_t, const FlightStep& step, Answer answer) override {
    ask_home();
    answer(simulator_.status().time, hils::give(casd_, step, false));
  }

  /// The flight is over.
  void finish(const Flight& flight, RunRecord& record) {
    advance(simulator_.status().time + kDrain);
    progress_.clear();
    if (simulator_.status().lockstep_timeouts > 0) {
      throw RunStopped(
          fmt::format("the controller left {} sensor messages without the control that was due",
                      simulator_.status().lockstep_timeouts),
          false);
    }
    record_flight(flight, 0, simulator_.status().time, record);
    record.outside_calls = read_outside_calls(casd_);
    std::ranges::move(read_simulator_calls(simulator_.client()),
                      std::back_inserter(record.outside_calls));
  }

 private:
  /// Asks for the home position, which commands build on. The answer comes after all that the
  /// vehicle has said: casd knows it by then.
  void ask_home() {
    try {
      casd_.call("vehicle.command",
                 {{"command", static_cast<int>(mavlink::common::MavCmd::kRequestMessage)},
                  {"params", {mavlink::common::HomePosition::kId}}});
    } catch (const base::rpc::CallError&) {
      return;  // it has none yet
    }
  }

  Supervisor& supervisor_;
  FlownSimulator simulator_;
  base::rpc::Client controller_;
  base::rpc::Client casd_;
  Progress progress_;
};

void fly(const RunRequest& request, const RunPaths& paths, Supervisor& supervisor,
         RunRecord& record) {
  LockstepBench bench(supervisor, paths);
  bench.meet();
  FlightLoop loop(flight_of(request.scenario), bench);
  loop.fly([&](bool) { bench.advance(loop.flight().plan.plan(0).next_look(bench.look())); });
  bench.finish(loop.flight(), record);
}

/// A ledger by the stream's clock, on which a packet is under way for no time.
std::vector<base::LedgerEntry> on_stream_time(std::vector<base::LedgerEntry> entries) {
  for (base::LedgerEntry& entry : entries) {
    entry.at_ns = static_cast<std::int64_t>(entry.time_usec) * 1000;
  }
  return entries;
}

/// The programs wake each other all the time; an idle processor that sleeps answers late. Where
/// this user may ask for it, processors stay awake during the flight.
base::CpuLatencyRequest keep_processors_awake() {
  const bool may_ask = ::access(base::CpuLatencyRequest::kDevice, W_OK) == 0;
  return base::CpuLatencyRequest(may_ask ? std::optional(0) : std::nullopt);
}

/// Lockstep allows nothing that runs by a clock of its own. @throws base::ConfigError
void refuse_other_clocks(const RunRequest& request) {
  if (request.scenario.flies_several()) {
    throw base::ConfigError(request.scenario.file.string() +
                            ": in lockstep hils flies one vehicle; --virtual flies several");
  }
  const auto refuse = [&](const std::string& what) {
    throw base::ConfigError(request.scenario.file.string() + ": " + what +
                            " has a clock of its own and no place in lockstep");
  };
  if (request.scenario.ground_station || request.station) refuse("a ground station");
  if (const auto& faults = request.scenario.faults.bench; !faults.empty()) {
    refuse("fault '" + faults.front().name + "' of the bench");
  }
  if (!request.fcu_devices.empty()) refuse("a real controller");
}

}  // namespace

std::vector<RunRecord> run_in_lockstep(const RunRequest& request) {
  refuse_other_clocks(request);
  const RunDirectory sockets;
  RunPaths paths = RunPaths::of(request.scenario, request.out, sockets.path());
  paths.command_port = sockets.command_socket();
  paths.choose_ports();
  const VehiclePaths& vehicle = paths.vehicles.front();
  Supervisor supervisor;  // before any thread: it blocks signals for all of them
  write_configs(request, Transport::kUdp, paths);

  std::vector<RunRecord> records = records_of(request.scenario, paths);
  RunRecord& record = records.front();
  record.virtual_clock = true;
  record.lockstep = true;
  record.log_clock.add(std::chrono::microseconds(casd::TlogWriter::kStreamEpoch).count(), 0);
  const base::CpuLatencyRequest awake = keep_processors_awake();
  BenchPrograms programs(supervisor, paths, request);
  programs.start(true);
  const base::RunTime begin = base::steady_now();
  try {
    fly(request, paths, supervisor, record);
  } catch (const base::rpc::ConnectionError& error) {
    supervisor.wait(milliseconds(500));  // a program that died is noticed within this time
    throw RunStopped(std::string("a control connection failed: ") + error.what(), false);
  }
  record.wall_s = base::to_seconds(base::steady_now() - begin);
  programs.stop(true);
  record.cpu_s = supervisor.cpu_s();
  record.simulator = on_stream_time(base::PacketLedger::read(vehicle.simulator_ledger()));
  record.controller = on_stream_time(base::PacketLedger::read(vehicle.controller_ledger()));
  add_simulator_report(paths, record);
  return records;
}

}  // namespace cas::hils
