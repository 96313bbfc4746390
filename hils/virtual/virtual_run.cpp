// SPDX-License-Identifier: BSD-3-Clause
#include "hils/virtual/virtual_run.hpp"

#include <signal.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "base/config/install_paths.hpp"
#include "base/error.hpp"
#include "base/os/result_file.hpp"
#include "base/random.hpp"
#include "base/time/clock.hpp"
#include "casd/tlog/tlog_files.hpp"
#include "casd/tlog/tlog_writer.hpp"
#include "casd/topology/topology.hpp"
#include "hils/flight/flight_loop.hpp"
#include "hils/measure/run_record.hpp"
#include "hils/programs/composition.hpp"
#include "hils/programs/ground_station.hpp"
#include "hils/programs/progress.hpp"
#include "hils/programs/scenario_flight.hpp"
#include "hils/programs/supervisor.hpp"
#include "hils/virtual/virtual_controller.hpp"
#include "hils/virtual/virtual_port.hpp"
#include "hils/virtual/virtual_relay.hpp"
#include "hils/virtual/virtual_simulator.hpp"
#include "libsim/core/run/left_world.hpp"

namespace cas::hils {

namespace {

/// Time zero of the virtual clock in flight.tlog, so that a log is the same whenever it is made.
constexpr std::int64_t kLogEpochUs =
    std::chrono::microseconds(casd::TlogWriter::kStreamEpoch).count();
/// For as long as that a vehicle that falls is followed after the flight.
constexpr base::Duration kLongestFall = std::chrono::seconds(10);
/// Placeholder for a port: the links of this topology are never opened.
constexpr std::uint16_t kAnyPort = 1;
constexpr base::Duration kShowPeriod = std::chrono::seconds(1);

/// flight.tlog of a run on the virtual clock.
class FlightLog {
 public:
  /// @throws base::ConfigError
  explicit FlightLog(base::ResultPlace place)
      : file_(base::open_result(place)), place_(std::move(place)) {}

  void write(base::Duration since_start, std::span<const std::uint8_t> packet) {
    record_.clear();
    const auto stamp_us = static_cast<std::uint64_t>(kLogEpochUs + since_start.count() / 1000);
    casd::append_tlog_record(stamp_us, packet, record_);
    std::fwrite(record_.data(), 1, record_.size(), file_.get());
  }

  /// @throws base::DiskError when something could not be written
  void close() { base::close_result(std::move(file_), place_); }

 private:
  base::OpenFile file_;
  base::ResultPlace place_;
  std::vector<std::uint8_t> record_;
};

/// Whether a signal came that an InterruptGuard took.
volatile sig_atomic_t interrupt_raised = 0;

/// Lets Ctrl-C end the run in good order while it lives.
class InterruptGuard {
 public:
  InterruptGuard() {
    interrupt_raised = 0;
    struct sigaction action {};
    action.sa_handler = [](int) { interrupt_raised = 1; };
    ::sigaction(SIGINT, &action, &before_int_);
    ::sigaction(SIGTERM, &action, &before_term_);
  }
  ~InterruptGuard() {
    ::sigaction(SIGINT, &before_int_, nullptr);
    ::sigaction(SIGTERM, &before_term_, nullptr);
  }
  InterruptGuard(const InterruptGuard&) = delete;
  InterruptGuard& operator=(const InterruptGuard&) = delete;
  static bool raised() { return interrupt_raised != 0; }

 private:
  struct sigaction before_int_ {};
  struct sigaction before_term_ {};
};

/// One vehicle's part of the bench: casd's links for it, and its controller behind a line.
class BenchVehicle {
 public:
  BenchVehicle(VirtualRelay& relay, const VehiclePaths& paths)
      : to_simulator_(relay.link(paths.simulator_link)),
        to_controller_(relay.link(paths.controller_link)),
        controller_(
            fcu::FcuConfig::load(paths.fcu_config()),
            [this, &relay](auto bytes, auto now) { relay.receive(to_controller_, bytes, now); }),
        line_(controller_.line().config()) {
    relay.connect(to_controller_,
                  [this](auto bytes, auto now) { return controller_.write(bytes, now); });
  }

  casd::LinkId to_simulator() const { return to_simulator_; }
  casd::LinkId to_controller() const { return to_controller_; }
  VirtualController& controller() { return controller_; }
  const VirtualController& controller() const { return controller_; }

  /// The line as the fault has it; as it was, when that ends.
  void set_line(const LineFault& fault, bool begins) {
    controller_.line().configure(begins ? fault.line : line_);
  }
  void unplug(bool begins) { begins ? controller_.line().hang_up() : controller_.line().restore(); }

 private:
  casd::LinkId to_simulator_;
  casd::LinkId to_controller_;
  VirtualController controller_;
  fcu::LineConfig line_;  ///< as it is without faults
};

/// The whole bench as one discrete-event simulation.
class VirtualBench final : public FlightBench {
 public:
  VirtualBench(const RunRequest& request, const RunPaths& paths)
      : scenario_(request.scenario),
        stats_file_{paths.out, paths.simulator_stats()},
        log_({paths.out, paths.flight_tlog()}),
        topology_(casd::Topology::load(paths.casd_config())),
        seed_(request.seed),
        relay_(topology_, wake_up(request.scenario.wake_up)),
        vehicles_(bench_vehicles(paths)),
        simulator_(sim::SimConfig::load(paths.simulator_config()),
                   {.output_dir = paths.out, .plugin_dirs = base::plugin_dirs()}, ways_out()),
        port_(relay_.commander(), casd::GainMap::load(topology_.gains),
              [this] { return port_now_; }),
        loop_(flight_of(scenario_), *this) {
    for (std::size_t i = 0; i < vehicles_.size(); ++i) {
      relay_.connect(vehicles_[i]->to_simulator(), [this, i](auto bytes, auto now) {
        simulator_.wire(i).write(bytes, now);
        return bytes.size();
      });
    }
    if (scenario_.ground_station) connect_ground_station();
    relay_.on_packet([this](casd::LinkId from, const mav::PacketView& packet, base::RunTime now) {
      const bool from_controller = std::ranges::any_of(
          vehicles_, [from](const auto& vehicle) { return vehicle->to_controller() == from; });
      if (from_controller) log_.write(now.time_since_epoch(), packet.bytes);
    });
  }

  void fly() {
    std::optional<base::RunTime> end;
    base::RunTime latest{};
    for (base::RunTime now{}; !end || now < *end; now = next_event(now)) {
      advance(now);
      if (loop_.flight().plan.ended()) {
        if (!end) latest = now + kLongestFall;
        // A falling vehicle is followed to the ground.
        if (!end || (something_falls() && now < latest)) end = now + kDrain;
      }
      if (InterruptGuard::raised()) throw RunStopped("interrupted", true);
    }
    progress_.clear();
    simulator_.finish();
    base::write_result(stats_file_, simulator_.stats_json());
    log_.close();
  }

  void fill(std::size_t vehicle, RunRecord& record) const {
    record_flight(loop_.flight(), vehicle, simulator_.time(), record);
    const BenchVehicle& on_bench = *vehicles_[vehicle];
    record.simulator = simulator_.wire(vehicle).ledger();
    record.controller = on_bench.controller().ledger();
    record.relay = RelayLedgers{.simulator = relay_.ledger(on_bench.to_simulator()),
                                .controller = relay_.ledger(on_bench.to_controller())};
    record.log_clock.add(kLogEpochUs, 0);
  }

  base::SimTime look() override { return base::SimTime(now_.time_since_epoch()); }
  Motion truth(std::size_t vehicle) const override { return simulator_.motion(vehicle); }
  std::optional<VehicleReport> report(std::size_t vehicle) override {
    return port_.report(scenario_.vehicles[vehicle].system_id);
  }
  void tell_phase(std::string_view phase) override { simulator_.set_flight_phase(phase); }

  /// casd reports on its own ticks and packets.
  void give(Flight&, std::size_t vehicle, const FlightStep& step, Answer answer) override {
    if (const auto sticks = held_sticks(step)) {
      ground_station_->hold(scenario_.vehicles[vehicle].system_id, *sticks);
    }
    port_.give(step, scenario_.vehicles[vehicle].system_id,
               [this, answer = std::move(answer)](const std::optional<Refusal>& refusal) {
                 answer(base::SimTime(port_now_.time_since_epoch()), refusal);
               });
  }

  void play(const Flight&, const BenchFault& fault, bool begins) override {
    BenchVehicle& vehicle = *vehicles_[fault.vehicle];
    if (const auto* line = std::get_if<LineFault>(&fault.kind)) {
      vehicle.set_line(*line, begins);
    } else if (std::holds_alternative<UnplugFault>(fault.kind)) {
      vehicle.unplug(begins);
    } else if (std::holds_alternative<RestartFault>(fault.kind)) {
      begins ? relay_.kill() : relay_.restart();
    } else if (const auto* flood = std::get_if<FloodFault>(&fault.kind)) {
      if (ground_station_) ground_station_->flood(begins ? flood->packets_hz : 0);
    } else if (const auto* silence = std::get_if<SilenceFault>(&fault.kind)) {
      if (silence->sticks) return ground_station_->lose_sticks(begins);
      relay_.silence(begins);
      if (ground_station_) ground_station_->silence(begins);
    } else if (const auto* starve = std::get_if<StarveFault>(&fault.kind)) {
      relay_.set_wake_up(wake_up(begins ? starve->wake_up : scenario_.wake_up));
    }
  }

  void show(base::SimTime now, const FlightPlan& plan, const VehicleReport& vehicle) override {
    if (now < next_show_) return;
    next_show_ = now + kShowPeriod;
    const double wall_s = std::max(base::to_seconds(base::steady_now() - begin_), 1e-9);
    progress_.show(now, plan, vehicle, pace_words(base::to_seconds(now) / wall_s));
  }

 private:
  WakeUp wake_up(const WakeUpFigures& figures) const {
    return {figures, base::derive_seed(seed_, "wake_up")};
  }

  std::vector<std::unique_ptr<BenchVehicle>> bench_vehicles(const RunPaths& paths) {
    std::vector<std::unique_ptr<BenchVehicle>> vehicles;
    for (const VehiclePaths& vehicle : paths.vehicles) {
      vehicles.push_back(std::make_unique<BenchVehicle>(relay_, vehicle));
    }
    return vehicles;
  }

  /// Packets of the simulator enter casd by the vehicle's link.
  std::vector<VirtualSimulator::OnBytes> ways_out() {
    std::vector<VirtualSimulator::OnBytes> ways;
    for (const auto& vehicle : vehicles_) {
      ways.emplace_back([this, link = vehicle->to_simulator()](auto bytes, auto now) {
        relay_.receive(link, bytes, now);
      });
    }
    return ways;
  }

  void connect_ground_station() {
    const casd::LinkId link = relay_.link("gcs");
    ground_station_.emplace(scenario_.systems(), kParameterListPeriod,
                            [this, link](auto bytes) { relay_.receive(link, bytes, now_); });
    relay_.connect(link, [this](auto bytes, auto) {
      ground_station_->on_bytes(bytes);
      return bytes.size();
    });
  }

  bool something_falls() const {
    constexpr double kFalls_m_s = 2;  // a landing comes down at 0.7
    return std::ranges::any_of(loop_.flight().vehicles, [](const VehicleReport& vehicle) {
      return vehicle.truth && vehicle.truth->v_m_s.z() < -kFalls_m_s;
    });
  }

  /// Everything that is due at `now`, in an order that never changes.
  void advance(base::RunTime now) {
    now_ = now;
    if (now >= simulator_.next_event()) simulator_.step(now);
    relay_.run(now);
    for (const auto& vehicle : vehicles_) vehicle->controller().run(now);
    port_now_ = now;
    if (now >= next_turn_) {
      next_turn_ = now + FlightPlan::kLookPeriod;
      loop_.turn();
    }
    if (ground_station_ && now >= next_ground_tick_) {
      ground_station_->tick(now);
      next_ground_tick_ = now + GroundStation::kTickPeriod;
    }
  }

  base::RunTime next_event(base::RunTime now) const {
    base::RunTime next = std::min({simulator_.next_event(), relay_.next_event(), next_turn_});
    for (const auto& vehicle : vehicles_)
      next = std::min(next, vehicle->controller().next_event(now));
    if (ground_station_) next = std::min(next, next_ground_tick_);
    return std::max(next, now + base::Duration(1));  // time always goes on
  }

  const Scenario& scenario_;
  base::ResultPlace stats_file_;
  FlightLog log_;
  casd::Topology topology_;
  std::uint64_t seed_;
  VirtualRelay relay_;
  std::vector<std::unique_ptr<BenchVehicle>> vehicles_;
  VirtualSimulator simulator_;
  VirtualPort port_;
  FlightLoop loop_;
  std::optional<GroundStation> ground_station_;
  Progress progress_;
  const base::RunTime begin_ = base::steady_now();
  base::RunTime now_{};
  base::RunTime port_now_{};  ///< of the port's answers: the last moment that is done
  base::RunTime next_turn_{};
  base::RunTime next_ground_tick_{};
  base::SimTime next_show_{};
};

}  // namespace

std::vector<RunRecord> run_on_virtual_clock(const RunRequest& request) {
  const InterruptGuard interrupts;
  const base::RunTime begin = base::steady_now();
  for (const BenchFault& fault : request.scenario.faults.bench) {
    if (!std::holds_alternative<ReloadFault>(fault.kind)) continue;
    throw base::ConfigError(
        "fault '" + fault.name +
        "': reload needs casd as a program; on the virtual clock there is none");
  }
  RunPaths paths = RunPaths::of(request.scenario, request.out, request.out / "run");
  if (request.scenario.ground_station) paths.ground_station_port = kAnyPort;
  write_configs(request, Transport::kBus, paths);

  VirtualBench bench(request, paths);
  try {
    bench.fly();
  } catch (const sim::LeftWorldError& error) {
    throw RunStopped(error.what(), false);
  }
  const double wall_s = base::to_seconds(base::steady_now() - begin);
  std::vector<RunRecord> records = records_of(request.scenario, paths);
  for (std::size_t i = 0; i < records.size(); ++i) {
    bench.fill(i, records[i]);
    add_simulator_report(paths, records[i]);
    records[i].virtual_clock = true;
    records[i].wall_s = wall_s;
  }
  return records;
}

}  // namespace cas::hils
