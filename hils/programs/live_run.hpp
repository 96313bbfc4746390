// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <functional>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/rpc/client.hpp"
#include "base/time/clock.hpp"
#include "hils/flight/bench_fault.hpp"
#include "hils/flight/fleet_plan.hpp"
#include "hils/measure/figures_so_far.hpp"
#include "hils/measure/flight_changes.hpp"
#include "hils/measure/run_result.hpp"
#include "hils/programs/run_port.hpp"
#include "hils/programs/supervisor.hpp"
#include "hils/programs/web_view.hpp"
#include "hils/run/run_paths.hpp"
#include "hils/run/run_request.hpp"

namespace cas::hils {

/// A run that people watch in a browser: casweb beside it, and the port on which casweb gets
/// references, limits and the verdict, and orders faults by hand. It outlives the programs of the
/// run, so that the verdict reaches the page.
class LiveRun {
 public:
  LiveRun();
  ~LiveRun();
  LiveRun(const LiveRun&) = delete;
  LiveRun& operator=(const LiveRun&) = delete;

  /// The programs of the run listen. A page that cannot be shown stops no run.
  /// @param request  outlives the flight
  void start(const RunRequest& request, const RunPaths& paths, const Supervisor& supervisor);

  /// One look at the flight.
  /// @param start_m  where the vehicles stood at first: north, east, up
  void look(base::SimTime now, const FleetPlan& plan, std::span<const VehicleReport> vehicles,
            std::span<const Eigen::Vector3d> start_m);
  /// Begins a fault of a line. @throws base::rpc::CallError, base::ConfigError
  using BeginFault = std::function<void(const BenchFault& fault)>;
  /// Begins the faults that were requested since the last look, and answers the requests.
  void play_faults(base::SimTime now, std::span<const VehicleReport> vehicles,
                   BenchFaultScript& faults, base::rpc::Client& simulator, const BeginFault& begin);
  /// Whether a list of outside calls is due.
  bool wants_calls() const { return port_ && base::steady_now() >= next_calls_; }
  void show_calls(const std::vector<OutsideCall>& calls);
  /// The flight is over, and is judged.
  void end_flight() {
    if (port_) port_->end_faults();
  }
  void tell(const RunResult& result);
  /// The run ends without a verdict. Does nothing if the page knows the end already.
  void tell_end(const std::string& sentence);

  /// casweb was there and has ended: no page can resume a paused run.
  bool page_has_ended() const;
  /// Resumes the simulation.
  void resume(base::rpc::Client& simulator);

  /// Faults by hand, as acts of others.
  const std::vector<OutsideCall>& calls() const { return calls_; }

 private:
  using Json = nlohmann::json;
  struct Shown;

  Json inject(const Json& params, base::SimTime now, std::span<const VehicleReport> vehicles,
              BenchFaultScript& faults, base::rpc::Client& simulator, const BeginFault& begin);
  Json reference(base::SimTime now, const FleetPlan& plan,
                 std::span<const Eigen::Vector3d> start_m) const;
  Json status(base::SimTime now, const FleetPlan& plan) const;

  const RunRequest* request_ = nullptr;
  std::vector<bool> emulated_;     // by vehicle: has the emulated controller and its line
  std::unique_ptr<RunPort> port_;  // in front of casweb, which asks it
  std::optional<WebView> web_;
  std::vector<FiguresSoFar> so_far_;  // by vehicle
  std::vector<OutsideCall> calls_;
  std::unique_ptr<Shown> shown_;  // last data shown to the page
  bool told_ = false;             // how the run ended
  base::RunTime next_status_{};
  base::RunTime next_calls_{};
};

}  // namespace cas::hils
