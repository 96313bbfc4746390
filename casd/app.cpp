// SPDX-License-Identifier: BSD-3-Clause
#include "casd/app.hpp"

#include <algorithm>
#include <atomic>
#include <boost/asio/io_context.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/signal_set.hpp>
#include <boost/asio/steady_timer.hpp>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <exception>
#include <functional>
#include <future>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "base/config/config.hpp"
#include "base/error.hpp"
#include "base/os/log.hpp"
#include "base/os/notify.hpp"
#include "base/os/thread.hpp"
#include "base/os/write_file.hpp"
#include "base/rpc/address_in_use.hpp"
#include "base/rpc/server.hpp"
#include "base/text.hpp"
#include "base/time/unix_time.hpp"
#include "casd/autopilot_log/autopilot_logs.hpp"
#include "casd/autopilot_log/log_files.hpp"
#include "casd/link_set.hpp"
#include "casd/port/daemon_methods.hpp"
#include "casd/port/figure_methods.hpp"
#include "casd/port/link_methods.hpp"
#include "casd/port/metrics_port.hpp"
#include "casd/port/port_places.hpp"
#include "casd/port/vehicle_methods.hpp"
#include "casd/station/failure_desk.hpp"
#include "casd/station/gain_map.hpp"
#include "casd/station/vehicle_commander.hpp"
#include "casd/station_options.hpp"
#include "casd/topology/line_budget.hpp"
#include "casd/topology/link_change.hpp"
#include "casd/topology/topology_files.hpp"
#include "mavlink/common/hil_sensor.hpp"

namespace cas::casd {
namespace {

namespace asio = boost::asio;
using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr auto kWallTick = milliseconds(500);
constexpr auto kSettlePoll = milliseconds(5);
/// Neither READY nor link.add waits longer for a link that cannot open (a name server that does not
/// answer).
constexpr auto kSettlePatience = seconds(2);
constexpr auto kSummaryPeriod = seconds(5);
/// Longest that the stream is held for a turn of casd's own station (lockstep).
constexpr auto kTurnPatience = seconds(1);

GainMap load_gains(const Topology& topology) {
  return topology.gains.empty() ? GainMap::shipped() : GainMap::load(topology.gains);
}

CommanderOptions commander_options(const Topology& topology,
                                   std::function<std::string(LinkId)> link_name,
                                   std::function<std::vector<MessageRate>(LinkId)> request_rates) {
  CommanderOptions options = commander_options(topology);
  options.link_name = std::move(link_name);
  options.request_rates = std::move(request_rates);
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
  constexpr double kMaxAccepts_s = 200;
  base::rpc::ServerLimits limits;
  limits.max_accepts_s = kMaxAccepts_s;
  // In lockstep the vehicles wait for the program that flies them, not the other way round.
  if (topology.pace != Pace::kLockstep) limits.max_cpu_share = kServingShare;
  return limits;
}

/// Where the command port takes its figures from; both outlive it.
FiguresSource make_figures_source(const AppOptions& options, LinkSet& links,
                                  const std::set<std::string>& added,
                                  const VehicleMethods& vehicles, const Recorder& recorder) {
  return {.figures = &links.figures(),
          .topology = [&links]() -> const Topology& { return links.topology(); },
          .now = base::steady_now,
          .started = base::steady_now(),
          .name = options.name,
          .topology_file = options.topology_file.empty()
                               ? std::filesystem::path()
                               : std::filesystem::absolute(options.topology_file),
          .is_added = [&added](const std::string& link) { return added.contains(link); },
          .vehicles = [&vehicles] { return vehicles.vehicles(); },
          .recording = [&recorder] { return recorder.status(base::steady_now()); },
          .taps = &links.taps(),
          .echo = &links.echo(),
          .decoder = load_decoder(links.topology())};
}

/// Writes the figures of the run as JSON, beside the file and renamed.
void write_stats(const std::filesystem::path& file, const FigureMethods& figures) {
  try {
    // Texts of vehicles may hold any bytes; they must not keep the figures from being written.
    const std::string text =
        figures.status().dump(2, ' ', false, nlohmann::json::error_handler_t::replace);
    base::write_file(file, text + "\n", base::Durability::kCache);
  } catch (const base::ConfigError& error) {
    base::log::error(error.what());
  }
}

/// The logs of autopilots and the files that they go to.
class LogTaking {
 public:
  /// @throws base::ConfigError
  LogTaking(const TlogConfig& config, mav::Source self, VehicleCommander& commander)
      : config_(of(config)), files_(config_), logs_(config_, self, commander, files_) {}

  AutopilotLogs& logs() { return logs_; }

 private:
  static AutopilotLogConfig of(const TlogConfig& log) {
    AutopilotLogConfig config = *log.autopilot;
    if (config.folder.empty()) config.folder = log.folder;
    return config;
  }

  AutopilotLogConfig config_;
  LogFiles files_;
  AutopilotLogs logs_;
};

/// casd's own station: failures go to the simulator, logs to their files, all else to the
/// commander.
class OwnStation final : public Station {
 public:
  OwnStation(VehicleCommander& commander, FailureDesk& failures, std::optional<LogTaking>& logs)
      : commander_(commander), failures_(failures), logs_(logs) {}

  void on_packet(const Origin& from, const mav::PacketView& packet, base::RunTime now) override {
    const auto verdict = failures_.on_packet(from, packet, base::steady_now());
    if (verdict != FailureDesk::Verdict::kRefused) commander_.on_packet(from, packet, now);
    if (logs_) logs_->logs().on_packet(from, packet, now);
  }
  void tick(base::RunTime now) override {
    commander_.tick(now);
    if (logs_) logs_->logs().tick(now);
  }

 private:
  VehicleCommander& commander_;
  FailureDesk& failures_;
  std::optional<LogTaking>& logs_;
};

}  // namespace

/// Everything here runs on the thread of `io`, apart from the links.
struct App::Impl {
  Impl(AppOptions app_options, Topology first)
      : options(std::move(app_options)),
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
            {.now = [this] { return station_now(); },
             .link_name = [this](LinkId id) { return link_name(id); },
             .audit = [](const std::string& line) { base::log::info("audit: " + line); },
             .unix_us = [this] { return log_clock_us(); }}),
        figures(server, make_figures_source(options, links, added, vehicle_methods, recorder)) {
    if (lockstep()) {
      links.stream_time().enable([this](base::RunTime now) { hold_for_turn(now); });
      links.tlog().set_epoch(TlogWriter::kStreamEpoch);
      links.local().wake_for_all(false);
    }
    server.before_calls([this] {
      if (lockstep()) return listen_closely();
      asio::post(io,
                 [this] { plan_tick(); });  // after the calls: they may be requests to a vehicle
    });
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
              when_tried(add_link(request), base::steady_now() + kSettlePatience, std::move(tried));
            },
        .remove = [this](const std::string& name, bool force) { remove_link(name, force); },
        .audit =
            [this](const std::string& client, const std::string& method,
                   const nlohmann::json& params, const std::optional<std::string>& refusal) {
              vehicle_methods.audit_other(client, method, params, refusal);
            }};
  }

  FailureHooks failure_hooks() {
    return {.send =
                [this](std::span<const std::uint8_t> packet, std::span<const Path> to) {
                  links.local().send(packet, to, base::steady_now());
                },
            .permits = [this](LinkId id) { return may_inject(id); },
            .link_name = [this](LinkId id) { return link_name(id); },
            .hil_doubt =
                [this](std::uint8_t system) { return commander.hil_doubt(system, station_now()); },
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

  bool lockstep() const { return links.topology().pace == Pace::kLockstep; }

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
    sample.at = base::steady_now() - (station_now() - kept->at);  // lockstep has another clock
    return sample;
  }

  /// The clock of casd's own station.
  base::RunTime station_now() const {
    return lockstep() ? links.stream_time().now() : base::steady_now();
  }

  /// The clock of a recording's stamps, as TlogWriter makes them.
  std::int64_t log_clock_us() const {
    if (!lockstep()) return base::unix_us();
    return std::chrono::duration_cast<std::chrono::microseconds>(
               TlogWriter::kStreamEpoch + links.stream_time().now().time_since_epoch())
        .count();
  }

  void take_turn(base::RunTime now) {
    links.local().wake_for_all(false);
    hear(now);
    station.tick(now);
  }

  /// Lockstep: telemetry wakes the main thread, which would share a processor with the stream, only
  /// from a client's call to the next turn of the station. So the client gets new values, and
  /// immediate answers even while the simulation is paused.
  void listen_closely() {
    links.local().wake_for_all(true);
    hear(station_now());
  }

  /// Gives the station its packets.
  void hear(base::RunTime now) {
    links.local().dispatch(station, now);
    recorder.on_vehicles(commander.any_armed(now), now);
  }

  /// Lockstep, on a link's thread: holds the stream while the station has its turn on the main
  /// thread. The wait is bounded, because a reload waits for link threads and at the end no turn
  /// comes.
  void hold_for_turn(base::RunTime now) {
    if (ending.load()) return;
    const auto over = std::make_shared<std::promise<void>>();
    asio::post(io, [this, now, over] {
      take_turn(now);
      over->set_value();
    });
    over->get_future().wait_for(kTurnPatience);
  }

  std::string link_name(LinkId id) const {
    const std::string name = links.figures().name(id);
    return name.empty() ? "?" : name;
  }

  void listen() {
    const CommandPortConfig& port = links.topology().command_port;
    const std::filesystem::path token = command_token(port);
    if (!token.empty()) server.require_token(token, port.loopback_without_token);
    const std::uint16_t bound = listen_tcp(port);
    command_endpoint = port.address + ":" + std::to_string(bound);
    for (const CommandSocket& socket : command_sockets(port, bound)) listen_on(socket);
    if (const auto& http = links.topology().metrics) {
      metrics_endpoint =
          http->address + ":" + std::to_string(metrics.listen(http->address, http->port));
    }
  }

  /// Opens the command port. @return its number
  /// @throws base::ConfigError that names it, and the way out if another program has it
  std::uint16_t listen_tcp(const CommandPortConfig& port) {
    const std::string what = "command port ";
    try {
      return server.listen_tcp(port.address, port.port);
    } catch (const base::rpc::AddressInUse& error) {
      throw base::ConfigError(what + error.what() +
                              "; a second casd takes another with 'command_port: {port: N}' (0: a "
                              "free one), or beside endpoints with '--command-port N'");
    } catch (const base::ConfigError& error) {
      throw base::ConfigError(what + error.what());
    }
  }

  /// @throws base::ConfigError
  void listen_on(const CommandSocket& socket) {
    try {
      server.listen_unix(socket.path, socket.group);
      if (unix_endpoint.empty()) unix_endpoint = socket.path.string();
    } catch (const base::ConfigError& error) {
      if (socket.required) throw;
      warn_not_found(error.what());
    }
  }

  void run() {
    const std::optional<AutopilotLogConfig>& autopilot = links.topology().log.autopilot;
    if (autopilot) log_taking.emplace(links.topology().log, links.topology().self, commander);
    recorder.begin();
    warn_of_narrow_lines();
    if (!options.ledger_file.empty()) links.figures().keep_ledgers();
    links.start();
    station_events.assign(links.local().descriptor());
    do_wait_signal();
    do_wait_station();
    if (lockstep()) {
      do_wall_tick();  // the stream gives the turns
    } else {
      do_tick(base::steady_now() + kStationTick);
    }
    do_second();
    settle_deadline = base::steady_now() + kSettlePatience;
    do_settle();
    io.run();
    base::notify("STOPPING=1");
    ending.store(true);
    station_events.release();
    if (log_taking) log_taking->logs().end(station_now());
    links.stop();
    if (!options.ledger_file.empty()) {
      write_link_ledgers(options.ledger_file, links.figures().ledgers());
    }
    recorder.stop();
    if (!options.stats_file.empty()) write_stats(options.stats_file, figures);
  }

  void warn_of_narrow_lines() {
    for (const std::string& line : line_budget_warnings(links.topology())) base::log::warn(line);
  }

  void do_wait_signal() {
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

  /// The links and routes of a topology, all or, with an exception, none.
  void change_links(Topology topology) {
    const LinkMask gone = links.reload(std::move(topology));
    // A new link may get the number of one that is gone: packets of the old one are heard first.
    failures.begin_reload(gone, base::steady_now());
    hear(station_now());
    failures.end_reload();
    commander.forget(gone);
  }

  /// @throws base::ConfigError, and nothing has changed
  std::string add_link(const base::ConfigNode& request) {
    std::vector<std::uint8_t> vehicles;
    for (const VehicleState* vehicle : commander.vehicles()) {
      vehicles.push_back(vehicle->source().system);
    }
    Topology topology = with_link(links.topology(), request, vehicles);
    const std::string name = topology.links.back().name;
    change_at_run_time(std::move(topology));
    added.insert(name);
    base::log::info("link " + name + ": added at run time");
    warn_of_narrow_lines();
    return name;
  }

  /// Calls `then` once a link has tried to open, at the latest at `until`.
  void when_tried(const std::string& link, base::RunTime until,
                  std::function<void(const std::string&)> then) {
    const auto is_opening = [&link](const LinkStatus& status) {
      return status.name == link && status.state == LinkState::kOpening;
    };
    const bool waits = std::ranges::any_of(links.figures().links(), is_opening);
    if (!waits || base::steady_now() >= until) return then(link);
    const auto timer = std::make_shared<asio::steady_timer>(io, kSettlePoll);
    timer->async_wait(
        [this, timer, link, until, then = std::move(then)](boost::system::error_code error) {
          if (!error) when_tried(link, until, then);
        });
  }

  /// @throws base::ConfigError, and nothing has changed
  void remove_link(const std::string& name, bool force) {
    Topology topology = without_link(links.topology(), name);
    if (const auto system = armed_vehicle_of(name); system && !force) {
      throw base::ConfigError("vehicle " + std::to_string(*system) + " is armed and on link '" +
                              name + "' alone; \"force\" removes it all the same");
    }
    change_at_run_time(std::move(topology));
    added.erase(name);
    base::log::info("link " + name + ": removed at run time");
  }

  /// Turns every exception, also for lack of descriptors or threads, into a ConfigError.
  void change_at_run_time(Topology topology) {
    try {
      change_links(std::move(topology));
    } catch (const std::exception& error) {
      throw base::ConfigError(error.what());
    }
  }

  /// An armed vehicle that casd hears on no other link.
  std::optional<std::uint8_t> armed_vehicle_of(const std::string& link) const {
    const base::RunTime now = station_now();
    for (const VehicleState* vehicle : commander.vehicles()) {
      const auto hangs_here = [&](const Path& path) {
        return link_name(path.link) == link && vehicle->hangs_on(path.link, now);
      };
      if (vehicle->armed() && std::ranges::any_of(vehicle->paths(), hangs_here)) {
        return vehicle->source().system;
      }
    }
    return std::nullopt;
  }

  /// The file is the truth: links that were added at run time end unless it has them.
  void forget_added() {
    for (const std::string& name : std::exchange(added, {})) {
      if (find_link(links.topology().links, name) != nullptr) continue;
      base::log::info("link " + name + ": not in the topology, ended");
    }
  }

  /// All or, with an exception, nothing: steps that may fail come first.
  void put_in_force(Topology topology) {
    std::shared_ptr<const MessageDecoder> decoder = load_decoder(topology);
    GainMap gains = load_gains(topology);
    change_links(std::move(topology));
    const CommandingConfig& commanding = links.topology().commanding;
    commander.set_commanding(commanding.heartbeat_hz, commanding.allow_not_hil);
    plan_tick();
    vehicle_methods.set_gains(std::move(gains));
    figures.set_decoder(std::move(decoder));
  }

  /// @return why not; nullopt when the new topology is in force
  std::optional<std::string> reload() {
    base::notify("RELOADING=1");
    std::optional<std::string> trouble;
    try {
      put_in_force(load_again());
      warn_of_narrow_lines();
      base::log::info("topology reloaded");
      forget_added();
    } catch (const std::exception& error) {  // also for lack of descriptors or threads
      trouble = error.what();
      base::log::error("topology not reloaded, the old one stays in force: " + *trouble);
    }
    figures.set_last_reload({.at = base::steady_now(), .trouble = trouble});
    settle_deadline = base::steady_now() + kSettlePatience;
    do_settle();
    return trouble;
  }

  void do_wait_station() {
    station_events.async_wait(asio::posix::stream_descriptor::wait_read,
                              [this](boost::system::error_code error) {
                                if (error) return;
                                hear(station_now());
                                plan_tick();
                                do_wait_station();
                              });
  }

  void do_tick(base::RunTime due) {
    next_tick = due;
    tick_timer.expires_after(due - base::steady_now());
    tick_timer.async_wait([this](boost::system::error_code error) {
      if (error) return;
      const base::RunTime now = base::steady_now();
      station.tick(now);
      failures.tick(now);
      recorder.on_vehicles(commander.any_armed(now), now);
      do_tick(tick_due(now));
    });
  }

  base::RunTime tick_due(base::RunTime now) const {
    const base::RunTime due = std::min(commander.next_tick(now), failures.due());
    return log_taking ? std::min(due, now + kStationTick) : due;
  }

  /// Something may have become due sooner.
  void plan_tick() {
    if (lockstep()) return;
    const base::RunTime due = tick_due(base::steady_now());
    if (due < next_tick) do_tick(due);
  }

  /// Ends requests to a vehicle whose simulator is paused, and takes packets that arrived after the
  /// last turn.
  void do_wall_tick() {
    tick_timer.expires_after(kWallTick);
    tick_timer.async_wait([this](boost::system::error_code error) {
      if (error) return;
      hear(station_now());
      commander.wall_tick(base::steady_now());
      failures.tick(base::steady_now());
      do_wall_tick();
    });
  }

  void do_second() {
    second_timer.expires_after(seconds(1));
    second_timer.async_wait([this](boost::system::error_code error) {
      if (error) return;
      const base::RunTime now = base::steady_now();
      links.figures().sample(now);
      links.local().tick(now);
      figures.publish();
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
      return link.name + " " + std::string(to_string(link.state)) + " rx " +
             std::to_string(link.rx.packets) + " tx " + std::to_string(link.tx.packets);
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
    std::string status = "command_port " + command_endpoint;
    if (!unix_endpoint.empty()) status += " command_socket " + unix_endpoint;
    if (!metrics_endpoint.empty()) status += " metrics " + metrics_endpoint;
    status += " " + links.endpoints();
    // systemd takes no longer message: with all of a hundred links it would miss READY.
    constexpr std::size_t kMostNotified = 4000;
    base::notify("READY=1\nSTATUS=" + status.substr(0, kMostNotified));
    base::log::info("ready: " + status);
  }

  AppOptions options;
  asio::io_context io;
  asio::signal_set signals{io, SIGTERM, SIGINT, SIGHUP};
  asio::steady_timer tick_timer{io};
  asio::steady_timer second_timer{io};
  asio::steady_timer settle_timer{io};
  asio::posix::stream_descriptor station_events{io};
  base::rpc::Server server;
  mutable LinkSet links;
  std::set<std::string> added;  ///< links, at run time
  VehicleCommander commander;
  FailureDesk failures;
  std::optional<LogTaking> log_taking;
  OwnStation station{commander, failures, log_taking};
  Recorder recorder;
  VehicleMethods vehicle_methods;
  FigureMethods figures;
  MetricsPort metrics{[this](MetricsPort::Take take) {
    asio::post(io, [this, take = std::move(take)] { take(figures.metrics_source()); });
  }};
  std::string command_endpoint;
  std::string unix_endpoint;     ///< empty: none
  std::string metrics_endpoint;  ///< empty: none
  base::RunTime settle_deadline{};
  base::RunTime next_summary{};
  base::RunTime next_tick = base::RunTime::max();  ///< of the station; max: none is awaited
  std::atomic<bool> ending{false};                 ///< no more turns
};

App::App(AppOptions options, Topology topology)
    : impl_(std::make_unique<Impl>(std::move(options), std::move(topology))) {}

App::~App() = default;

void App::listen() { impl_->listen(); }

void App::run() { impl_->run(); }

}  // namespace cas::casd
