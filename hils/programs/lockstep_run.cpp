// SPDX-License-Identifier: BSD-3-Clause
#include "hils/programs/lockstep_run.hpp"

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <iterator>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>

#include "base/os/cpu_latency.hpp"
#include "base/rpc/client.hpp"
#include "base/time/clock.hpp"
#include "casd/tlog/tlog_writer.hpp"
#include "hils/programs/bench_programs.hpp"
#include "hils/programs/composition.hpp"
#include "hils/programs/pilot_calls.hpp"
#include "hils/programs/progress.hpp"
#include "hils/programs/supervisor.hpp"
#include "hils/run/run_places.hpp"
#include "mavlink/common/enums.hpp"
#include "mavlink/common/home_position.hpp"

namespace cas::hils {

namespace {

using base::rpc::Json;
using std::chrono::milliseconds;
using std::chrono::seconds;

/// For a stretch of the stream, on a machine that may be very busy.
constexpr base::Duration kCallPatience = seconds(120);
/// The stream goes on for this long after the flight, so that the pipe is drained.
constexpr base::Duration kDrain = seconds(1);

/// The answer of fcu.status as a report.
VehicleReport to_report(const Json& status) {
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

/// Flies the plan: reads the state and gives commands while simulated time is stopped.
///
///   run_until(next look) -> fcu.status -> plan -> command, acknowledged -> run_until ...
class LockstepPilot {
 public:
  LockstepPilot(Supervisor& supervisor, const RunPlaces& places, std::vector<FlightStep> steps)
      : supervisor_(supervisor),
        simulator_(connect("unix:" + places.simulator_control().string())),
        controller_("unix:" + places.vehicles.front().fcu_control().string()),
        casd_(connect("unix:" + places.command_port.string())),
        plan_(std::move(steps)) {}

  void fly(RunRecord& record) {
    meet();
    while (true) {
      const VehicleReport vehicle = look();
      const std::optional<FlightStep> command = plan_.update(now_, vehicle);
      tell_phase();
      if (plan_.done() || plan_.failure()) break;
      progress_.show(now_, plan_, vehicle, pace_words(factor_));
      if (command) plan_.on_outcome(now_, give(*command));
      advance(plan_.next_look(now_));
    }
    advance(now_ + kDrain);
    progress_.clear();
    if (timeouts_ > 0) {
      throw RunStopped("the controller left " + std::to_string(timeouts_) +
                           " sensor messages without the control that was due",
                       false);
    }
    record.simulated_s = base::to_seconds(now_);
    record.flight_failure = plan_.failure();
    record.stages = plan_.stages();
    record.under_way = plan_.under_way(now_);
    record.hold = plan_.measured();
    record.outside_calls = read_outside_calls(casd_);
    std::ranges::move(read_simulator_calls(simulator_), std::back_inserter(record.outside_calls));
  }

 private:
  void advance(base::SimTime time) {
    supervisor_.check();
    const Json status =
        simulator_.call("sim.run_until", {{"time_s", base::to_seconds(time)}}, kCallPatience);
    now_ = base::SimTime(base::from_seconds(status.at("time_s").get<double>()));
    factor_ = status.at("real_time_factor").get<double>();
    timeouts_ = status.at("lockstep_timeouts").get<std::uint64_t>();
    truth_ = to_motion(status.at("vehicles").at(0));
    if (!start_m_) start_m_ = truth_->p_m;
    truth_->p_m -= *start_m_;
  }

  /// Lets the vehicle say its first words.
  void meet() {
    advance(base::SimTime(FlightPlan::kLookPeriod));
    const base::RunTime deadline = base::steady_now() + kCallPatience;
    while (!vehicle_report(casd_).heard) {
      if (base::steady_now() > deadline) throw RunStopped("casd never heard the controller", false);
      supervisor_.wait(milliseconds(2));
    }
  }

  VehicleReport look() {
    VehicleReport report =
        plan_.from_arming(to_report(controller_.call("fcu.status", Json::object())));
    report.truth = truth_;
    return report;
  }

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

  /// @return why the vehicle refused, or nothing
  std::optional<Refusal> give(const FlightStep& step) {
    ask_home();
    return hils::give(casd_, step, false);
  }

  /// The simulator's fault scripts ask for it.
  void tell_phase() {
    if (plan_.phase() == phase_) return;
    phase_ = plan_.phase();
    simulator_.call("sim.phase", {{"name", phase_}});
  }

  Supervisor& supervisor_;
  base::rpc::Client simulator_;
  base::rpc::Client controller_;
  base::rpc::Client casd_;
  FlightPlan plan_;
  Progress progress_;
  std::string phase_;
  base::SimTime now_{};
  double factor_ = 0;
  std::uint64_t timeouts_ = 0;
  std::optional<Motion> truth_;
  std::optional<Eigen::Vector3d> start_m_;
};

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
  RunPlaces places = RunPlaces::of(request.scenario, request.out, sockets.path());
  places.command_port = sockets.command_socket();
  places.choose_ports();
  const VehiclePlaces& vehicle = places.vehicles.front();
  Supervisor supervisor;  // before any thread: it blocks signals for all of them
  write_configs(request, Transport::kUdp, places);

  std::vector<RunRecord> records = records_of(request.scenario, places);
  RunRecord& record = records.front();
  record.virtual_clock = true;
  record.lockstep = true;
  record.log_clock.add(std::chrono::microseconds(casd::TlogWriter::kStreamEpoch).count(), 0);
  const base::CpuLatencyRequest awake = keep_processors_awake();
  BenchPrograms programs(supervisor, places, request);
  programs.start(true);
  const base::RunTime begin = base::steady_now();
  try {
    LockstepPilot(supervisor, places, request.scenario.steps).fly(record);
  } catch (const base::rpc::ConnectionError& error) {
    supervisor.wait(milliseconds(500));  // a program that died is noticed within this time
    throw RunStopped(std::string("a control connection failed: ") + error.what(), false);
  }
  record.wall_s = base::to_seconds(base::steady_now() - begin);
  programs.stop(true);
  record.cpu_s = supervisor.cpu_s();
  record.simulator = on_stream_time(base::PacketLedger::read(vehicle.simulator_ledger()));
  record.controller = on_stream_time(base::PacketLedger::read(vehicle.controller_ledger()));
  add_simulator_report(places, record);
  return records;
}

}  // namespace cas::hils
