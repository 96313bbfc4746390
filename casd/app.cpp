// SPDX-License-Identifier: BSD-3-Clause
#include "casd/app.hpp"

#include <unistd.h>

#include <fmt/format.h>
#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/signal_set.hpp>
#include <boost/asio/steady_timer.hpp>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "base/error.hpp"
#include "base/os/log.hpp"
#include "base/os/notify.hpp"
#include "base/os/write_file.hpp"
#include "base/rpc/io_thread.hpp"
#include "base/rpc/server.hpp"
#include "base/text.hpp"
#include "casd/link_changes.hpp"
#include "casd/link_set.hpp"
#include "casd/own_station.hpp"
#include "casd/port/daemon_methods.hpp"
#include "casd/port/figure_methods.hpp"
#include "casd/port/metrics_port.hpp"
#include "casd/port/open_ports.hpp"
#include "casd/port/vehicle_methods.hpp"
#include "casd/station/failure_injector.hpp"
#include "casd/station/gain_map.hpp"
#include "casd/station/vehicle_commander.hpp"
#include "casd/station_options.hpp"
#include "casd/station_scheduler.hpp"
#include "casd/topology/line_budget.hpp"
#include "casd/topology/topology_files.hpp"
#include "mavlink/common/hil_sensor.hpp"

namespace cas::casd {
namespace {

namespace asio = boost::asio;
using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr auto kSettlePoll = milliseconds(5);
/// Neither READY nor link.add waits longer for a link that cannot open (a name server that does not
/// answer).
constexpr auto kSettlePatience = seconds(5);
constexpr auto kSummaryPeriod = seconds(5);

GainMap load_gains(const Topology& topology) {
  return topology.gains.empty() ? GainMap::shipped() : GainMap::load(topology.gains);
}

CommanderOptions commander_options(const Topology& topology,
                                   std::function<std::string(LinkId)> link_name,
                                   std::function<std::vector<MessageRate>(LinkId)> request_rates) {
  CommanderOptions options = commander_options(topology);
  options.link_name = std::move(link_name);
  if (topology.pace != Pace::kLockstep) options.request_rates = std::move(request_rates);
  return options;
}

/// Names and values of the generated dialect and of the topology's own. @throws base::ConfigError
std::shared_ptr<const MessageDecoder> load_decoder(const Topology& topology) {
  auto decoder = std::make_shared<MessageDecoder>();
  if (!topology.dialect.empty()) add_dialect(topology.dialect, *decoder);
  return decoder;
}

/// The main thread also sends the station's packets and shares the processors with the link
/// threads: clients that only watch must not keep it busy.
base::rpc::ServerLimits server_limits(const Topology& topology) {
  constexpr double kServingShare = 0.03;
  constexpr double kMaxAccepts_s = 1000;  // a full backlog is through in four seconds
  base::rpc::ServerLimits limits;
  limits.max_accepts_s = kMaxAccepts_s;
  // In lockstep the vehicles wait for the program that flies them, not the other way round.
  if (topology.pace != Pace::kLockstep) limits.max_cpu_share = kServingShare;
  return limits;
}

/// Where the command port takes its figures from; all outlive it.
FiguresSource make_figures_source(const AppOptions& options, LinkSet& links,
                                  const LinkChanges& changes, const VehicleMethods& vehicles,
                                  const Recorder& recorder, const OwnStation& station) {
  return {.figures = &links.figures(),
          .topology = [&links]() -> const Topology& { return links.topology(); },
          .now = base::steady_now,
          .started = base::steady_now(),
          .name = options.name,
          .topology_file = options.topology_file.empty()
                               ? std::filesystem::path()
                               : std::filesystem::absolute(options.topology_file),
          .is_added = [&changes](const std::string& link) { return changes.is_added(link); },
          .vehicles = [&vehicles] { return vehicles.vehicles(); },
          .recorder = &recorder,
          .autopilot_logs = [&station] { return station.logs(base::steady_now()); },
          .taps = &links.taps(),
          .echo = &links.echo(),
          .decoder = load_decoder(links.topology())};
}

void warn_of_narrow_lines(const Topology& topology) {
  for (const std::string& line : line_budget_warnings(topology)) base::log::warn(line);
}

/// Writes the figures of the run as JSON, beside the file and renamed.
void write_stats(const std::filesystem::path& file, const FigureMethods& figures) {
  // Texts of vehicles may hold any bytes; they must not keep the figures from being written.
  const std::string text =
      figures.status().dump(2, ' ', false, nlohmann::json::error_handler_t::replace);
  base::write_file(file, text + "\n", base::Durability::kCache);
}

/// @throws base::ConfigError when the file could not be written at the end
void require_writable(const std::filesystem::path& file) {
  if (file.empty()) return;
  namespace fs = std::filesystem;
  std::error_code none;
  const fs::path found = fs::canonical(file, none);  // what a symlink leads to is written
  const fs::path place = none ? file : found;
  int error = 0;
  if (fs::is_directory(place, none)) {
    error = EISDIR;
  } else if (fs::is_other(place, none)) {  // a pipe or a terminal
    error = ::access(place.c_str(), W_OK) == 0 ? 0 : errno;
  } else {
    const fs::path folder = place.has_parent_path() ? place.parent_path() : ".";
    error = ::access(folder.c_str(), W_OK | X_OK) == 0 ? 0 : errno;
  }
  if (error == 0) return;
  throw base::ConfigError(file.string() + ": cannot be written: " + base::error_text(error));
}

/// Refuses, before anything starts, files that could not be written at the end.
AppOptions with_writable_files(AppOptions options) {
  require_writable(options.ledger_file);
  require_writable(options.stats_file);
  return options;
}

}  // namespace

/// Everything here runs on the thread of `io`, apart from the links.
struct App::Impl {
  Impl(AppOptions app_options, Topology first)
      : options(with_writable_files(std::move(app_options))),
        server(io, server_limits(first)),
        links(std::move(first)),
        commander(commander_options(
                      links.topology(), [this](LinkId id) { return link_name(id); },
                      [this](LinkId id) { return request_rates(id); }),
                  [this](std::span<const std::uint8_t> packet, std::span<const Path> to) {
                    links.local().send(packet, to, base::steady_now());
                  }),
        failures(links.topology().self, commander, failure_hooks()),
        recorder(links.tlog(), links.topology().log),
        vehicle_methods(
            server, commander, load_gains(links.topology()),
            {.now = [this] { return scheduler.now(); },
             .link_name = [this](LinkId id) { return link_name(id); },
             .audit = [](const std::string& line) { base::log::info("audit: " + line); },
             .unix_us = [this] { return scheduler.log_clock_us(); }}),
        figures(server,
                make_figures_source(options, links, changes, vehicle_methods, recorder, station)) {
    server.before_calls([this] { scheduler.before_call(); });
    figures.set_memory([this](const MessageTaps::Key& key) { return remembered(key); });
    commander.on_notice([](const std::string& notice) { base::log::warn(notice); });
    commander.on_failure([this](std::uint8_t system, const VehicleCommand& command, Done done) {
      failures.inject(system, command, base::steady_now(), std::move(done));
    });
    add_daemon_methods(
        server, {.reload = [this] { return reload(); },
                 .recorder = recorder,
                 .post = [this](std::function<void()> work) { asio::post(io, std::move(work)); }});
    add_link_methods(server, link_hooks());
  }

  LinkHooks link_hooks() {
    return {
        .add =
            [this](const base::ConfigNode& request, std::function<void(const std::string&)> tried) {
              const std::string name = changes.add(request);
              warn_of_narrow_lines(links.topology());
              changes.when_tried(name, base::steady_now() + kSettlePatience, std::move(tried));
            },
        .remove = [this](const std::string& name, bool force) { changes.remove(name, force); },
        .audit =
            [this](const std::string& client, const std::string& method,
                   const nlohmann::json& params, const std::optional<std::string>& refusal) {
              vehicle_methods.audit_other(client, method, params, refusal);
            }};
  }

  FailureHooks failure_hooks() {
    return {
        .send =
            [this](std::span<const std::uint8_t> packet, std::span<const Path> to) {
              links.local().send(packet, to, base::steady_now());
            },
        .permits = [this](LinkId id) { return may_inject(id); },
        .link_name = [this](LinkId id) { return link_name(id); },
        .hil_doubt =
            [this](std::uint8_t system) { return commander.hil_doubt(system, scheduler.now()); },
        .simulator = [this](std::uint8_t system) { return simulator_of(system); },
        .audit = [](const std::string& line) { base::log::info("audit: " + line); }};
  }

  std::vector<MessageRate> request_rates(LinkId id) const {
    const LinkConfig* const link = find_link(links.topology().links, link_name(id));
    return link == nullptr ? std::vector<MessageRate>() : link->request_rates;
  }

  bool may_inject(LinkId id) const {
    const LinkConfig* const link = find_link(links.topology().links, link_name(id));
    return link != nullptr && link->inject_failures;
  }

  /// The simulator whose HIL_SENSOR goes to the vehicle's link.
  std::optional<Simulator> simulator_of(std::uint8_t system) const {
    const VehicleState* const vehicle = commander.find(system);
    if (vehicle == nullptr) return std::nullopt;
    const auto sender = links.figures().sender_of(mavlink::common::HilSensor::kId, vehicle->link());
    if (!sender) return std::nullopt;
    return Simulator{.source = sender->first, .path = {.link = sender->second}};
  }

  /// A vehicle's newest message on a link, for the first look at it.
  std::optional<MessageTaps::Sample> remembered(const MessageTaps::Key& key) const {
    const VehicleState* vehicle = commander.find(key.source.system);
    if (vehicle == nullptr || vehicle->source() != key.source || vehicle->link() != key.link) {
      return std::nullopt;
    }
    const MessageMemory::Kept* kept = vehicle->messages().find(key.message_id);
    if (kept == nullptr) return std::nullopt;
    MessageTaps::Sample sample;
    sample.size = std::min(kept->payload.size(), sample.payload.size());
    std::copy_n(kept->payload.begin(), sample.size, sample.payload.begin());
    sample.at = base::steady_now() - (scheduler.now() - kept->at);  // lockstep has another clock
    return sample;
  }

  std::string link_name(LinkId id) const {
    const std::string name = links.figures().name(id);
    return name.empty() ? "?" : name;
  }

  void listen() { ports = open_ports(links.topology(), server, metrics); }

  void run() {
    station.take_logs(links.topology().log, links.topology().self);
    recorder.begin();
    warn_of_narrow_lines(links.topology());
    if (!options.ledger_file.empty()) links.figures().keep_ledgers();
    try {
      run_links();
    } catch (...) {  // link threads end before the objects that they call
      scheduler.end();
      links.stop();
      throw;
    }
    base::notify("STOPPING=1");
    scheduler.end();
    station.end_logs(scheduler.now());
    links.stop();
    recorder.stop();
    if (!options.stats_file.empty()) write_stats(options.stats_file, figures);
    if (!options.ledger_file.empty()) {
      write_link_ledgers(options.ledger_file, links.figures().ledgers());
    }
  }

  /// Until a signal ends it.
  void run_links() {
    links.start();
    settle_deadline = base::steady_now() + kSettlePatience;
    base::rpc::run_context(io, "main", [this] {
      do_wait_signal();
      scheduler.begin();
      do_second();
      if (!told_ready) do_settle();
      server.start();
    });
  }

  void do_wait_signal() {
    signals.cancel();
    signals.async_wait([this](boost::system::error_code error, int signal) {
      if (error) return;
      if (signal != SIGHUP) return stop();
      reload();
      do_wait_signal();
    });
  }

  void stop() {
    base::log::info("stopping");
    server.close();
    metrics.close();
    io.stop();
  }

  /// @throws base::ConfigError also for keys that only a restart can change
  Topology load_again() const {
    if (options.topology_file.empty()) {
      throw base::ConfigError(
          "casd was started with endpoints, not with a file: there is nothing "
          "to read again");
    }
    const std::vector<base::ConfigNode> files = load_topology_files(options.topology_file);
    Topology topology = Topology::parse(files);
    if (options.lockstep) topology.set_lockstep();
    refuse_restart_keys(links.topology(), topology, overlaid(files));
    return topology;
  }

  /// All or, with an exception, nothing: steps that may fail come first.
  void put_in_force(Topology topology) {
    std::shared_ptr<const MessageDecoder> decoder = load_decoder(topology);
    GainMap gains = load_gains(topology);
    changes.apply(std::move(topology));
    const CommandingConfig& commanding = links.topology().commanding;
    commander.set_commanding(commanding.heartbeat_hz, commanding.allow_not_hil,
                             commanding.ask_on_sight && links.topology().pace != Pace::kLockstep);
    scheduler.plan();
    vehicle_methods.set_gains(std::move(gains));
    figures.set_decoder(std::move(decoder));
  }

  /// @return why not; nullopt when the new topology is in force
  std::optional<std::string> reload() {
    base::notify("RELOADING=1");
    std::optional<std::string> trouble;
    try {
      put_in_force(load_again());
      warn_of_narrow_lines(links.topology());
      base::log::info("topology reloaded");
      changes.forget_added();
    } catch (const std::exception& error) {  // also for lack of descriptors or threads
      trouble = error.what();
      base::log::error("topology not reloaded, the old one stays in force: " + *trouble);
    }
    figures.set_last_reload({.at = base::steady_now(), .trouble = trouble});
    settle_deadline = base::steady_now() + kSettlePatience;
    told_ready = false;
    do_settle();
    return trouble;
  }

  void do_second() {
    second_timer.expires_after(seconds(1));
    second_timer.async_wait([this](boost::system::error_code error) {
      if (error) return;
      const base::RunTime now = base::steady_now();
      links.figures().sample(now);
      links.local().tick(now);
      figures.publish();
      vehicle_methods.publish();
      feed_watchdog(now);
      if (now >= next_summary) summarise(now);
      do_second();
    });
  }

  /// systemd restarts casd when a link's thread hangs (WatchdogSec in the unit).
  void feed_watchdog(base::RunTime now) {
    if (std::getenv("WATCHDOG_USEC") == nullptr) return;
    if (links.alive(now)) {
      base::notify("WATCHDOG=1");
    } else {
      base::log::error("a link's thread hangs");
    }
  }

  void summarise(base::RunTime now) {
    next_summary = now + kSummaryPeriod;
    base::log::debug(base::joined(links.figures().links(), "; ", [](const LinkStatus& link) {
      return fmt::format("{} {} rx {} tx {}", link.name, to_string(link.state), link.rx.packets,
                         link.tx.packets);
    }));
  }

  /// READY once every link has tried to open, so that STATUS has the bound ports.
  void do_settle() {
    if (!links.settled() && base::steady_now() < settle_deadline) {
      settle_timer.expires_after(kSettlePoll);
      settle_timer.async_wait([this](boost::system::error_code error) {
        if (!error) do_settle();
      });
      return;
    }
    told_ready = true;
    const std::string status = describe(ports) + " " + links.endpoints();
    // systemd takes no longer message: with all of a hundred links it would miss READY.
    constexpr std::size_t kMostNotified = 4000;
    base::notify("READY=1\nSTATUS=" + status.substr(0, kMostNotified));
    base::log::info("ready: " + status);
  }

  AppOptions options;
  asio::io_context io;
  asio::signal_set signals{io, SIGTERM, SIGINT, SIGHUP};
  asio::steady_timer second_timer{io};
  asio::steady_timer settle_timer{io};
  base::rpc::Server server;
  mutable LinkSet links;
  VehicleCommander commander;
  FailureInjector failures;
  OwnStation station{commander, failures};
  Recorder recorder;
  StationScheduler scheduler{io, links, station, recorder};
  LinkChanges changes{io, links, commander, failures, scheduler};
  VehicleMethods vehicle_methods;
  FigureMethods figures;
  MetricsPort metrics{[this](MetricsPort::Take take) {
    asio::post(io, [this, take = std::move(take)] { take(figures.metrics_source()); });
  }};
  OpenPorts ports;
  base::RunTime settle_deadline{};
  bool told_ready = false;
  base::RunTime next_summary{};
};

App::App(AppOptions options, Topology topology)
    : impl_(std::make_unique<Impl>(std::move(options), std::move(topology))) {}

App::~App() = default;

void App::listen() { impl_->listen(); }

void App::run() { impl_->run(); }

}  // namespace cas::casd
