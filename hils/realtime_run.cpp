// SPDX-License-Identifier: BSD-3-Clause
#include "hils/realtime_run.hpp"

#include <chrono>
#include <nlohmann/json.hpp>
#include <optional>

#include "base/clock.hpp"
#include "base/install_paths.hpp"
#include "base/rpc/client.hpp"
#include "base/vehicle.hpp"
#include "hils/composition.hpp"
#include "hils/cpu_pressure.hpp"
#include "hils/ground_station_thread.hpp"
#include "hils/progress.hpp"
#include "hils/run_directory.hpp"
#include "hils/supervisor.hpp"

namespace cas::hils {

namespace {

using base::rpc::Json;
using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr base::Duration kReadyTimeout = seconds(20);
constexpr base::Duration kStopPatience = seconds(10);
constexpr base::Duration kPollPeriod = milliseconds(50);
/// The stream goes on for this long after the flight, so that the pipe is drained.
constexpr base::Duration kDrain = seconds(1);

std::int64_t log_clock_us() {
  return std::chrono::duration_cast<std::chrono::microseconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

std::filesystem::path program_folder() {
  return std::filesystem::read_symlink("/proc/self/exe").parent_path();
}

/// The three programs of a run.
class Programs {
 public:
  Programs(Supervisor& supervisor, const RunPlaces& places)
      : supervisor_(supervisor), places_(places) {}

  /// The controller first (it makes the PTY), then casd, then the simulator, which starts the
  /// stream.
  void start() {
    fcu_ = &supervisor_.start(
        options("fcu_emulator", places_.fcu_config(),
                {"--link", places_.fcu_link(), "--ledger", places_.controller_ledger(), "--control",
                 places_.fcu_control()}),
        kReadyTimeout);
    casd_ = &supervisor_.start(options("casd", places_.casd_config(), {}), kReadyTimeout);
    std::vector<std::string> arguments{"--control", places_.simulator_control(), "--output",
                                       places_.out};
    for (const std::filesystem::path& folder : base::plugin_dirs()) {
      arguments.insert(arguments.end(), {"--plugin-dir", folder});
    }
    hilsim_ =
        &supervisor_.start(options("hilsim", places_.simulator_config(), arguments), kReadyTimeout);
  }

  /// The simulator first, so that what it sent still arrives. @return sentences on bad ends
  void stop() {
    for (ChildProcess* child : {hilsim_, casd_, fcu_}) {
      if (!supervisor_.stop(*child, kStopPatience)) {
        throw RunStopped(
            child->name() + " did not end in good order; its last lines:" + child->log_tail(),
            false);
      }
    }
  }

 private:
  ChildProcess::Options options(const std::string& program, const std::filesystem::path& config,
                                const std::vector<std::string>& further) const {
    ChildProcess::Options options;
    options.name = program;
    options.arguments = {(program_folder() / program).string(), config.string(), "--stats",
                         (places_.run / (program + "_stats.json")).string()};
    options.arguments.insert(options.arguments.end(), further.begin(), further.end());
    options.log_file = places_.run / (program + ".log");
    options.notify_socket = places_.sockets / (program + ".notify");
    return options;
  }

  Supervisor& supervisor_;
  const RunPlaces& places_;
  ChildProcess* fcu_ = nullptr;
  ChildProcess* casd_ = nullptr;
  ChildProcess* hilsim_ = nullptr;
};

VehicleReport to_report(const Json& state) {
  VehicleReport report;
  report.heard = true;
  report.armed = state.value("armed", false);
  const std::string landed = state.value("landed", "");
  report.in_air = landed == "in_air";
  report.on_ground = landed == "on_ground";
  if (const auto p = state.find("position_N"); p != state.end() && p->is_object()) {
    report.has_position = true;
    report.p_N = {p->value("x_m", 0.0), p->value("y_m", 0.0), p->value("z_m", 0.0)};
    report.v_N = {p->value("vx_m_s", 0.0), p->value("vy_m_s", 0.0), p->value("vz_m_s", 0.0)};
  }
  if (const auto a = state.find("attitude"); a != state.end() && a->is_object()) {
    report.yaw_rad = a->value("yaw_rad", 0.0);
  }
  return report;
}

/// casd's method and parameters for a step.
std::pair<std::string, Json> to_call(const FlightStep& step) {
  switch (step.kind) {
    case StepKind::kArm:
      return {"vehicle.arm", Json::object()};
    case StepKind::kTakeoff:
      return {"vehicle.takeoff", {{"altitude_m", step.altitude_m}}};
    case StepKind::kGoto:
      return {"vehicle.goto",
              {{"north_m", step.place_m.x()},
               {"east_m", step.place_m.y()},
               {"down_m", -step.place_m.z()},
               {"yaw_deg", step.yaw_rad * 180.0 / M_PI}}};
    case StepKind::kSetGain: {
      Json params{{"loop", step.loop}};
      if (step.p) params["p"] = *step.p;
      if (step.i) params["i"] = *step.i;
      if (step.d) params["d"] = *step.d;
      return {"gain.set", params};
    }
    case StepKind::kLand:
      return {"vehicle.land", Json::object()};
    case StepKind::kDisarm:
      return {"vehicle.disarm", Json::object()};
    case StepKind::kHold:
      break;
  }
  return {"vehicle.hold", Json::object()};
}

/// Flies the plan over the two control connections.
class Pilot {
 public:
  Pilot(Supervisor& supervisor, const RunPlaces& places, std::vector<FlightStep> steps)
      : supervisor_(supervisor),
        simulator_("unix:" + places.simulator_control().string()),
        casd_("unix:" + places.command_port().string()),
        plan_(std::move(steps)) {}

  void fly(RunRecord& record) {
    while (true) {
      const base::SimTime now = simulated_time();
      record.log_clock.add(log_clock_us(), static_cast<std::int64_t>(base::to_time_usec(now)));
      const VehicleReport vehicle = look();
      const std::optional<FlightStep> command = plan_.update(now, vehicle);
      tell_phase();
      watch_machine();
      if (plan_.done() || !plan_.failure().empty()) break;
      progress_.show(now, plan_, vehicle, real_time_factor_);
      if (command) {
        plan_.on_outcome(simulated_time(), give(*command));
      } else {
        supervisor_.wait(kPollPeriod);
      }
    }
    supervisor_.wait(kDrain);
    record.simulated_s = base::to_seconds(simulated_time());
    record.flight_failure = plan_.failure();
    record.stages = plan_.stages();
    record.hold = plan_.measured();
    record.cpu_pressure = pressure_.share();
  }

 private:
  base::SimTime simulated_time() {
    const Json status = simulator_.call("sim.status", Json::object());
    real_time_factor_ = status.value("real_time_factor", 0.0);
    return base::SimTime(base::from_seconds(status.at("time_s").get<double>()));
  }

  /// The simulator's fault scripts ask for it.
  void tell_phase() {
    if (plan_.phase() == phase_) return;
    phase_ = plan_.phase();
    simulator_.call("sim.phase", {{"name", phase_}});
  }

  VehicleReport look() {
    try {
      return to_report(casd_.call("vehicle.state", Json::object()));
    } catch (const base::rpc::CallError& error) {
      if (error.code() == base::rpc::kNoSuchVehicle) return {};  // not heard yet
      throw;
    }
  }

  /// @return why the vehicle refused, or nothing
  std::string give(const FlightStep& step) {
    try {
      const auto [method, params] = to_call(step);
      casd_.call(method, params);
      return {};
    } catch (const base::rpc::CallError& error) {
      return error.what();
    }
  }

  /// Looks at the machine's load during the measured hold.
  void watch_machine() {
    const FlightStep* step = plan_.current();
    const bool measuring = step != nullptr && step->measure;
    if (measuring && !measuring_) pressure_.start();
    if (!measuring && measuring_) pressure_.stop();
    measuring_ = measuring;
  }

  Supervisor& supervisor_;
  base::rpc::Client simulator_;
  base::rpc::Client casd_;
  FlightPlan plan_;
  Progress progress_;
  CpuPressure pressure_;
  std::string phase_;
  bool measuring_ = false;
  double real_time_factor_ = 0;
};

}  // namespace

RunRecord run_in_real_time(const RunRequest& request) {
  const base::RunTime begin = base::steady_now();
  const RunDirectory sockets;
  const std::vector<std::uint16_t> ports = free_udp_ports(2);
  RunPlaces places{.out = request.out,
                   .run = request.out / "run",
                   .sockets = sockets.path(),
                   .simulator_port = ports[0],
                   .casd_port = ports[1]};
  Supervisor supervisor;  // before any thread: it blocks signals for all of them
  std::optional<GroundStationThread> ground_station;
  if (request.scenario.ground_station) {
    ground_station.emplace(base::Vehicle::load(request.scenario.vehicle).system_id);
    places.ground_station_port = ground_station->port();
  }
  write_configs(request, Transport::kUdp, places);

  RunRecord record;
  record.truth_csv = places.truth_csv();
  record.flight_tlog = places.flight_tlog();
  Programs programs(supervisor, places);
  programs.start();
  try {
    Pilot(supervisor, places, request.scenario.steps).fly(record);
  } catch (const base::rpc::ConnectionError& error) {
    supervisor.wait(milliseconds(500));  // a program that died is noticed within this time
    throw RunStopped(std::string("a control connection failed: ") + error.what(), false);
  }
  programs.stop();
  record.wall_s = base::to_seconds(base::steady_now() - begin);
  record.cpu_s = supervisor.cpu_s();
  record.simulator = base::PacketLedger::read(places.simulator_ledger());
  record.controller = base::PacketLedger::read(places.controller_ledger());
  return record;
}

}  // namespace cas::hils
