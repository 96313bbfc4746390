// SPDX-License-Identifier: BSD-3-Clause
#include "hils/virtual_run.hpp"

#include <signal.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <optional>

#include "base/clock.hpp"
#include "base/install_paths.hpp"
#include "base/random.hpp"
#include "casd/topology.hpp"
#include "hils/composition.hpp"
#include "hils/fault_history.hpp"
#include "hils/ground_station.hpp"
#include "hils/progress.hpp"
#include "hils/report.hpp"
#include "hils/supervisor.hpp"
#include "hils/tlog_writer.hpp"
#include "hils/virtual_controller.hpp"
#include "hils/virtual_pilot.hpp"
#include "hils/virtual_relay.hpp"
#include "hils/virtual_simulator.hpp"

namespace cas::hils {

namespace {

/// Time zero of the virtual clock in flight.tlog: 2026-01-01T00:00:00Z, so that a log is the same
/// whenever it is made.
constexpr std::int64_t kLogEpochUs = 1'767'225'600'000'000;
/// The stream goes on for this long after the flight, so that the pipe is drained.
constexpr base::Duration kDrain = std::chrono::seconds(1);
/// Stands for a port in a topology whose links are not opened.
constexpr std::uint16_t kAnyPort = 1;
constexpr base::Duration kShowPeriod = std::chrono::seconds(1);

std::int64_t log_clock_us(base::Duration since_start) {
  return kLogEpochUs + since_start.count() / 1000;
}

/// Lets Ctrl-C end the run in good order while it lives.
class InterruptGuard {
 public:
  InterruptGuard() {
    raised_ = 0;
    struct sigaction action {};
    action.sa_handler = [](int) { raised_ = 1; };
    ::sigaction(SIGINT, &action, &before_int_);
    ::sigaction(SIGTERM, &action, &before_term_);
  }
  ~InterruptGuard() {
    ::sigaction(SIGINT, &before_int_, nullptr);
    ::sigaction(SIGTERM, &before_term_, nullptr);
  }
  InterruptGuard(const InterruptGuard&) = delete;
  InterruptGuard& operator=(const InterruptGuard&) = delete;
  static bool raised() { return raised_ != 0; }

 private:
  static inline volatile sig_atomic_t raised_ = 0;
  struct sigaction before_int_ {};
  struct sigaction before_term_ {};
};

/// The whole bench as one discrete-event simulation.
class VirtualBench {
 public:
  VirtualBench(const RunRequest& request, const RunPlaces& places)
      : vehicle_(base::Vehicle::load(request.scenario.vehicle)),
        stats_file_(places.simulator_stats()),
        log_(places.flight_tlog()),
        topology_(casd::Topology::load(places.casd_config())),
        relay_(topology_,
               WakeUp(request.scenario.wake_up, base::derive_seed(request.seed, "wake_up"))),
        to_simulator_(relay_.link("sim")),
        to_controller_(relay_.link("fcu")),
        controller_(fcu::FcuConfig::load(places.fcu_config()),
                    [this](auto bytes, auto now) { relay_.receive(to_controller_, bytes, now); }),
        simulator_(sim::SimConfig::load(places.simulator_config()),
                   {.output_dir = places.out, .plugin_dirs = base::plugin_dirs()}, kVehicleName,
                   [this](auto bytes, auto now) { relay_.receive(to_simulator_, bytes, now); }),
        pilot_(relay_.commander(), vehicle_.system_id, casd::GainMap::load(topology_.gains),
               request.scenario.steps, [this] { return simulator_.motion(); }),
        line_(controller_.line().config()),
        faults_(request.scenario.faults.bench) {
    relay_.connect(to_simulator_, [this](auto bytes, auto now) {
      simulator_.write(bytes, now);
      return bytes.size();
    });
    relay_.connect(to_controller_,
                   [this](auto bytes, auto now) { return controller_.write(bytes, now); });
    if (request.scenario.ground_station) connect_ground_station();
    relay_.on_packet([this](casd::LinkId from, const mav::PacketView& packet, base::RunTime now) {
      if (from == to_controller_) log_.write(log_clock_us(now.time_since_epoch()), packet.bytes);
    });
  }

  void fly() {
    const base::RunTime begin = base::steady_now();
    std::optional<base::RunTime> end;
    for (base::RunTime now{}; !end || now < *end; now = next_event(now)) {
      advance(now);
      if (!end && (pilot_.plan().done() || !pilot_.plan().failure().empty())) end = now + kDrain;
      if (InterruptGuard::raised()) throw RunStopped("interrupted", true);
      show(now, begin);
    }
    progress_.clear();
    simulator_.finish();
    write_text(stats_file_, simulator_.stats_json());
    log_.close();
  }

  void fill(RunRecord& record) const {
    const FlightPlan& plan = pilot_.plan();
    record.simulator = simulator_.ledger();
    record.controller = controller_.ledger();
    record.relay = RelayLedgers{.simulator = relay_.ledger(to_simulator_),
                                .controller = relay_.ledger(to_controller_)};
    record.stages = plan.stages();
    record.hold = plan.measured();
    record.log_clock.add(kLogEpochUs, 0);
    record.faults = faults_.history();
    record.flight_failure = plan.failure();
    record.simulated_s = base::to_seconds(simulator_.time());
  }

 private:
  void connect_ground_station() {
    const casd::LinkId link = relay_.link("gcs");
    ground_station_.emplace(vehicle_.system_id, kParameterListPeriod,
                            [this, link](auto bytes) { relay_.receive(link, bytes, now_); });
    relay_.connect(link, [this](auto bytes, auto) {
      ground_station_->on_bytes(bytes);
      return bytes.size();
    });
  }

  /// Everything that is due at `now`, in an order that never changes.
  void advance(base::RunTime now) {
    now_ = now;
    if (now >= simulator_.next_event()) simulator_.step(now);
    relay_.run(now);
    controller_.run(now);
    pilot_.set_now(now);
    if (now >= pilot_.next_event()) {
      pilot_.run(now);
      simulator_.set_flight_phase(pilot_.plan().phase());
      play_faults(now);
    }
    if (ground_station_ && now >= next_ground_tick_) {
      ground_station_->tick(now);
      next_ground_tick_ = now + GroundStation::kTickPeriod;
    }
  }

  void play_faults(base::RunTime now) {
    const base::SimTime time(now.time_since_epoch());
    for (const auto& [fault, begins] :
         faults_.update(time, pilot_.vehicle(), pilot_.plan().phase())) {
      if (const auto* line = std::get_if<LineFault>(&fault->kind)) {
        controller_.line().configure(begins ? line->line : line_);
      } else if (std::holds_alternative<UnplugFault>(fault->kind)) {
        begins ? controller_.line().hang_up() : controller_.line().restore();
      } else if (std::holds_alternative<RestartFault>(fault->kind)) {
        begins ? relay_.kill() : relay_.restart();
      } else if (const auto* flood = std::get_if<FloodFault>(&fault->kind)) {
        if (ground_station_) ground_station_->flood(begins ? flood->packets_hz : 0);
      }
    }
  }

  base::RunTime next_event(base::RunTime now) const {
    base::RunTime next = std::min({simulator_.next_event(), relay_.next_event(),
                                   controller_.next_event(now), pilot_.next_event()});
    if (ground_station_) next = std::min(next, next_ground_tick_);
    return std::max(next, now + base::Duration(1));  // time always goes on
  }

  void show(base::RunTime now, base::RunTime begin) {
    if (now < next_show_) return;
    next_show_ = now + kShowPeriod;
    const double wall_s = std::max(base::to_seconds(base::steady_now() - begin), 1e-9);
    progress_.show(base::SimTime(now.time_since_epoch()), pilot_.plan(), pilot_.vehicle(),
                   base::to_seconds(now) / wall_s);
  }

  base::Vehicle vehicle_;
  std::filesystem::path stats_file_;
  TlogWriter log_;
  casd::Topology topology_;
  VirtualRelay relay_;
  casd::LinkId to_simulator_;
  casd::LinkId to_controller_;
  VirtualController controller_;
  VirtualSimulator simulator_;
  VirtualPilot pilot_;
  fcu::LineConfig line_;  ///< as it is without faults
  BenchFaultScript faults_;
  std::optional<GroundStation> ground_station_;
  Progress progress_;
  base::RunTime now_{};
  base::RunTime next_ground_tick_{};
  base::RunTime next_show_{};
};

}  // namespace

RunRecord run_on_virtual_clock(const RunRequest& request) {
  const InterruptGuard interrupts;
  const base::RunTime begin = base::steady_now();
  const RunPlaces places{
      .out = request.out,
      .run = request.out / "run",
      .sockets = request.out / "run",
      .ground_station_port = request.scenario.ground_station ? kAnyPort : std::uint16_t{0}};
  write_configs(request, Transport::kBus, places);

  VirtualBench bench(request, places);
  bench.fly();
  RunRecord record;
  bench.fill(record);
  for (auto& fault : vehicle_faults(places.simulator_stats())) {
    record.faults.push_back(std::move(fault));
  }
  record.truth_csv = places.truth_csv();
  record.flight_tlog = places.flight_tlog();
  record.virtual_clock = true;
  record.wall_s = base::to_seconds(base::steady_now() - begin);
  return record;
}

}  // namespace cas::hils
