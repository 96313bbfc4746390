// SPDX-License-Identifier: BSD-3-Clause
#include "hils/direct_run.hpp"

#include <signal.h>

#include <algorithm>
#include <chrono>

#include "base/clock.hpp"
#include "base/config.hpp"
#include "base/install_paths.hpp"
#include "casd/topology.hpp"
#include "hils/composition.hpp"
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
class DirectBench {
 public:
  DirectBench(const Scenario& scenario, std::uint64_t seed, const RunPlaces& places)
      : vehicle_(base::Vehicle::load(scenario.vehicle)),
        log_(places.flight_tlog()),
        topology_(casd::Topology::parse(
            base::ConfigNode::parse(casd_config(scenario, places), places.casd_config()))),
        relay_(topology_),
        to_simulator_(relay_.link("sim")),
        to_controller_(relay_.link("fcu")),
        controller_(fcu::FcuConfig::parse(
                        base::ConfigNode::parse(fcu_config(scenario, seed), places.fcu_config())),
                    [this](auto bytes, auto now) { relay_.receive(to_controller_, bytes, now); }),
        simulator_(sim::SimConfig::parse(base::ConfigNode::parse(
                       simulator_config(scenario, seed, Transport::kBus, places),
                       places.simulator_config())),
                   {.output_dir = places.out, .plugin_dirs = base::plugin_dirs()}, kVehicleName,
                   [this](auto bytes, auto now) { relay_.receive(to_simulator_, bytes, now); }),
        pilot_(relay_.commander(), vehicle_.system_id, casd::GainMap::load(topology_.gains),
               scenario.steps) {
    relay_.connect(to_simulator_, [this](auto bytes, auto now) {
      simulator_.write(bytes, now);
      return bytes.size();
    });
    relay_.connect(to_controller_,
                   [this](auto bytes, auto now) { return controller_.write(bytes, now); });
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
    log_.close();
  }

  void fill(RunRecord& record) const {
    const FlightPlan& plan = pilot_.plan();
    record.simulator = simulator_.ledger();
    record.controller = controller_.ledger();
    record.stages = plan.stages();
    record.hold = plan.measured();
    record.log_clock.add(kLogEpochUs, 0);
    record.flight_failure = plan.failure();
    record.simulated_s = base::to_seconds(simulator_.time());
  }

 private:
  /// Everything that is due at `now`, in an order that never changes.
  void advance(base::RunTime now) {
    if (now >= simulator_.next_event()) simulator_.step(now);
    relay_.run(now);
    controller_.run(now);
    if (now >= pilot_.next_event()) pilot_.run(now);
  }

  base::RunTime next_event(base::RunTime now) const {
    base::RunTime next = std::min({simulator_.next_event(), relay_.next_event(),
                                   controller_.next_event(), pilot_.next_event()});
    if (const auto room = controller_.room_at(now)) next = std::min(next, *room);
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
  TlogWriter log_;
  casd::Topology topology_;
  VirtualRelay relay_;
  casd::LinkId to_simulator_;
  casd::LinkId to_controller_;
  VirtualController controller_;
  VirtualSimulator simulator_;
  VirtualPilot pilot_;
  Progress progress_;
  base::RunTime next_show_{};
};

}  // namespace

RunRecord run_direct(const Scenario& scenario, std::uint64_t seed,
                     const std::filesystem::path& out) {
  const InterruptGuard interrupts;
  const base::RunTime begin = base::steady_now();
  const RunPlaces places{.out = out, .run = out / "run", .sockets = out / "run"};
  std::filesystem::create_directories(places.run);
  write_text(places.simulator_config(), simulator_config(scenario, seed, Transport::kBus, places));
  write_text(places.fcu_config(), fcu_config(scenario, seed));
  write_text(places.casd_config(), casd_config(scenario, places));

  DirectBench bench(scenario, seed, places);
  bench.fly();
  RunRecord record;
  bench.fill(record);
  record.truth_csv = places.truth_csv();
  record.flight_tlog = places.flight_tlog();
  record.virtual_clock = true;
  record.wall_s = base::to_seconds(base::steady_now() - begin);
  return record;
}

}  // namespace cas::hils
