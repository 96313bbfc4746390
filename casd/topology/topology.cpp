// SPDX-License-Identifier: BSD-3-Clause
#include "casd/topology/topology.hpp"

#include <algorithm>
#include <set>
#include <span>
#include <string>
#include <string_view>

#include "base/config/changed_keys.hpp"
#include "base/config/config_keys.hpp"
#include "base/config/file_kind.hpp"
#include "base/config/install_paths.hpp"
#include "base/config/removed_keys.hpp"
#include "base/os/cpu_latency.hpp"
#include "base/os/thread_keys.hpp"
#include "casd/tlog/tlog_name.hpp"
#include "casd/topology/endpoint_conflict.hpp"
#include "casd/topology/line_budget.hpp"
#include "casd/topology/message_keys.hpp"
#include "casd/topology/topology_files.hpp"

namespace cas::casd {
namespace {

constexpr int kSchema = 1;

using base::block;
using base::ConfigNode;
using base::Flag;
using base::key;
using base::PathBeside;
using base::Range;
using base::ReadApart;
using base::Text;
using base::Whole;
using base::Words;

// Kinds of values that only a topology has.

/// The period of the checks of `tcdrain`; 0: it is woken at once.
struct DrainTick : Range {
  void read(const ConfigNode& node, base::Duration& tick) const {
    Range::read(node, tick);
    if (tick > base::Duration{} && tick < LineDrain::kLeastTick) {
      node.fail("the kernel's tick is 0 (none) or at least 0.1 ms");
    }
  }
};

/// A socket's path; empty: none.
struct UnixSocket : Text {
  static void read(const ConfigNode& node, std::filesystem::path& path) {
    const auto text = node.as<std::string>();
    if (text.empty()) node.fail("is empty; `none` means no Unix socket");
    path = text == "none" ? "" : text;
  }
  static std::string text(const std::filesystem::path& path) { return path.string(); }
};

struct TlogName : Text {
  static void read(const ConfigNode& node, std::string& name) {
    Text::read(node, name);
    if (const auto fault = tlog_name_fault(name)) {
      node.fail("'" + name + "' " + *fault + "; it is a name, and its folder is `folder`");
    }
  }
};

struct Folder : Text {
  static void read(const ConfigNode& node, std::filesystem::path& folder) {
    folder = node.as<std::string>();
  }
  static std::string text(const std::filesystem::path& folder) { return folder.string(); }
};

/// A file that may lie among the shipped ones.
struct ConfigFile : Text {
  static void read(const ConfigNode& node, std::filesystem::path& file) {
    file = base::find_config(node);
  }
  static std::string text(const std::filesystem::path& file) { return Text::text(file.string()); }
  static std::array<std::string, 2> samples() { return {"$DIR/a", "$DIR/b"}; }
};

constexpr Words<ThreadModel, 4> kThreadModels{{{{"auto", ThreadModel::kAuto},
                                                {"per_link", ThreadModel::kPerLink},
                                                {"single", ThreadModel::kSingle},
                                                {"blocking", ThreadModel::kBlocking}}}};
constexpr Words<Pace, 2> kPaces{{{{"realtime", Pace::kRealtime}, {"lockstep", Pace::kLockstep}}}};

// Blocks

constexpr Whole kPort{0, 65535};

constexpr std::tuple kCommandPortKeys{
    key<&CommandPortConfig::address>("address", Text{}, "JSON-RPC over TCP"),
    key<&CommandPortConfig::port>("port", kPort, "0 takes a free one"),
    key<&CommandPortConfig::unix_path>("unix", UnixSocket{},
                                       "path of a Unix socket, or `none`; see below", "see below"),
    key<&CommandPortConfig::unix_group>(
        "unix_group", Text{}, "whose members may connect to the Unix socket", "see below"),
    key<&CommandPortConfig::token_file>("token_file", PathBeside{},
                                        "what TCP clients must know, made where it is missing",
                                        "see below"),
    key<&CommandPortConfig::loopback_without_token>("loopback_without_token", Flag{},
                                                    "TCP clients of this machine need no token"),
};

void check_command_port(const ConfigNode& node, const CommandPortConfig& port) {
  const auto group = node.find("unix_group");
  if (group && port.unix_path && port.unix_path->empty()) {
    group->fail("has no meaning with `unix: none`");
  }
}

constexpr std::tuple kMetricsKeys{
    key<&MetricsConfig::address>("address", Text{},
                                 "readable for everybody who reaches the address"),
    key<&MetricsConfig::port>("port", kPort, "0 takes a free one"),
};

constexpr std::tuple kCommandingKeys{
    key<&CommandingConfig::heartbeat_hz>("heartbeat_hz", Range{0, 100},
                                         "own HEARTBEAT; 0: none; in lockstep at most 20"),
    key<&CommandingConfig::allow_not_hil>("allow_not_hil", Flag{},
                                          "consent to arm or move a vehicle that is not in HIL"),
    key<&CommandingConfig::ask_on_sight>(
        "ask_on_sight", Flag{},
        "ask a vehicle that appears or restarts for AUTOPILOT_VERSION and HOME_POSITION, and an "
        "ArduPilot for telemetry; never in lockstep"),
};

constexpr double kMib = 1024 * 1024;

constexpr std::tuple kKeepKeys{
    key<&LogLimits::max_bytes>("max_mib", Range{0, 1e8, kMib},
                               "all .tlog files together, and all .ulg and .bin files; 0: any",
                               "0, of logs of autopilots 4096"),
    key<&LogLimits::max_files>("max_files", Whole{0, 1'000'000},
                               "so many dated .tlog files, and so many dated .ulg and .bin files; "
                               "0: all"),
    key<&LogLimits::free_space_min_bytes>("free_space_min_mib", Range{0, 1e8, kMib},
                                          "stays free on the disk"),
};

/// Whoever says how much stays wants the rest deleted.
struct Keep : base::Block<LogLimits, decltype(kKeepKeys)> {
  void read(const ConfigNode& node, LogLimits& limits) const {
    if (!node.is_map()) {
      node.fail("is a block {max_mib, max_files, free_space_min_mib} that holds for all logs");
    }
    Block::read(node, limits);
    limits.delete_oldest = true;
  }
};

constexpr std::tuple kAutopilotLogKeys{
    key<&AutopilotLogConfig::while_armed>("while_armed", Flag{},
                                          "of each vehicle while it is armed; false: always"),
    key<&AutopilotLogConfig::systems>("systems", Ids{}, "of these vehicles (system ids) alone",
                                      "all"),
};

constexpr std::tuple kLogKeys{
    key<&TlogConfig::tlog>("tlog", TlogName{},
                           "a recording of that name begins with casd, or with each flight"),
    key<&TlogConfig::folder>("folder", Folder{},
                             "the folder of all logs, made where it alone is missing",
                             "`$LOGS_DIRECTORY` (the service has /var/log/cas), else the working "
                             "folder"),
    key<&TlogConfig::rotation, &TlogRotation::max_bytes>(
        "rotate_mib", Range{0, 1e8, kMib},
        "a file of that size is followed by the next, DATE-NAME.1.tlog; 0: any"),
    key<&TlogConfig::keep>("keep", Keep{{kKeepKeys}}, ""),
    key<&TlogConfig::autopilot>("autopilot", block<AutopilotLogConfig>(kAutopilotLogKeys),
                                "takes the logs of autopilots, too; see below"),
    key<&TlogConfig::while_armed>("while_armed", Flag{},
                                  "a recording whenever a vehicle is armed; see below"),
    key<&TlogConfig::overwrite>("overwrite", Flag{},
                                "the recording from the start is NAME.tlog itself, over the old "
                                "file"),
};

void refuse_limits(const ConfigNode& node) {
  constexpr const char* kNow = "write it in `log: {keep: {...}}`, which holds for all logs";
  base::refuse_removed(
      node,
      {{"max_mib", kNow},
       {"max_files", kNow},
       {"free_space_min_mib", kNow},
       {"delete_oldest", "with `log: {keep: {...}}` the oldest are deleted, without it none"}});
}

void check_log(const ConfigNode& node, const TlogConfig& log) {
  refuse_limits(node);
  base::refuse_removed(node, {{"rotate_minutes",
                               "files of a recording are divided by size (`rotate_mib`), or by "
                               "time if `casctl log start --rotate-minutes` began it"}});
  if (log.overwrite && log.while_armed) {
    node.at("overwrite").fail("each flight of while_armed has a file of its own");
  }
  const auto autopilot = node.find("autopilot");
  if (!autopilot) return;
  if (!autopilot->is_map()) {
    autopilot->fail("is a block, of which every key may be left out: {}");
  }
  refuse_limits(*autopilot);
  base::refuse_removed(*autopilot, {{"folder", "all logs go to the `folder` of `log`"}});
  const auto systems = autopilot->find("systems");
  if (systems && log.autopilot->systems.empty()) systems->fail("names no vehicle");
  if (std::ranges::count(log.autopilot->systems, 0) > 0) systems->fail("0 is no vehicle's id");
}

// A reload refuses other values of these keys:

constexpr Whole kId{1, 255};

constexpr std::tuple kRestartKeys{
    key<&Topology::self, &mav::Source::system>("system_id", kId, "casd as a ground station"),
    key<&Topology::self, &mav::Source::component>("component_id", kId, "its component"),
    key<&Topology::threads>(
        "threads", kThreadModels,
        "one thread for the links and one more for each link that floods, a thread "
        "for each link, one thread for all, or one thread that waits for the "
        "line (for comparison)"),
    key<&Topology::drain_tick>("drain_tick_ms", DrainTick{{0, 10, 1e-3}},
                               "with `threads: blocking`: how often the thread looks whether the "
                               "line is through; 0: woken the moment it is"),
    key<&Topology::pace>(
        "pace", kPaces,
        "`lockstep`: casd's station runs on the time of the HIL_SENSOR stream, "
        "lines are not paced and nothing in a queue grows old "
        "([simulator.md](../use/simulator.md#lockstep)); `--lockstep` does the same"),
    key<&Topology::scheduling>("scheduling", block<base::ThreadOptions>(base::kThreadKeys),
                               "of the link threads"),
    key<&Topology::seek_core>(
        "seek_core", Flag{},
        "a link thread of 100 to 5000 packets a second tries its processors and stays on the one "
        "where a packet costs least ([operations.md](../use/operations.md#real-time))"),
    key<&Topology::cpu_dma_latency_us>(
        "cpu_dma_latency_us", Whole{0, base::CpuLatencyRequest::kLongest_us},
        "longest time that an idle processor may take to wake while casd runs; 0: the lightest "
        "idle state there is, on x86 it polls, which costs power "
        "([operations.md](../use/operations.md#real-time))"),
    key<&Topology::command_port>(
        "command_port", block<CommandPortConfig>(kCommandPortKeys, check_command_port), ""),
    key<&Topology::metrics>("metrics", block<MetricsConfig>(kMetricsKeys),
                            "figures for Prometheus at `http://ADDRESS:PORT/metrics`; see below"),
    key<&Topology::log>("log", block<TlogConfig>(kLogKeys, check_log), ""),
};

// and puts new values of these in force:

constexpr std::tuple kReloadKeys{
    key<&Topology::duplicate_window>(
        "duplicate_window_ms", Range{0, 60'000, 1e-3},
        "a packet that comes again within this time, over whichever link, goes on once; 0: only "
        "over links of one `group`, up to 10 s late"),
    key<&Topology::commanding>("commanding", block<CommandingConfig>(kCommandingKeys), ""),
    key<&Topology::dialect>("dialect", ConfigFile{},
                            "MAVLink XML (with what it includes): names and values of its messages "
                            "are shown without a rebuild, before those of casd's own dialect"),
    key<&Topology::gains>("gains", ConfigFile{}, "loop name -> parameter names, per autopilot",
                          "the shipped ones"),
    key<&Topology::links>("links", ReadApart{"list"}, "see below"),
    key<&Topology::routes>("routes", ReadApart{"list"}, "see below", "all to all"),
};

/// The defaults.
Topology standard_topology() {
  Topology topology;
  topology.log.folder = default_log_folder();
  topology.log.keep.free_space_min_bytes = LogLimits::kFreeSpaceMin;
  return topology;
}

void refuse_conflicts(const ConfigNode& node, const LinkConfig& link,
                      std::span<const LinkConfig> before, const CommandPortConfig& port) {
  if (const auto conflict = endpoint_conflict(link, before)) node.fail(*conflict);
  if (const auto conflict = endpoint_conflict(link, port)) node.fail(*conflict);
}

std::vector<LinkConfig> parse_links(const std::vector<ConfigNode>& files, const ConfigNode& root,
                                    const CommandPortConfig& command_port) {
  base::expect_file(root, base::FileKind::kTopology);
  root.at("links");
  std::vector<LinkConfig> links;
  std::set<std::string> names;
  for (const base::ConfigNode& node : overlaid_list(files, "links", {"name"})) {
    LinkConfig link = parse_link(node);
    refuse_conflicts(node, link, links, command_port);
    links.push_back(std::move(link));
    if (!names.insert(links.back().name).second) {
      node.at("name").fail("'" + links.back().name + "' is the name of another link");
    }
    if (links.size() > kMaxLinks) node.fail("more than 250 links");
  }
  if (links.empty()) root.at("links").fail("no link");
  return links;
}

std::vector<RouteConfig> parse_routes(const std::vector<ConfigNode>& files, const ConfigNode& root,
                                      const std::vector<LinkConfig>& links) {
  if (!root.has("routes")) return routes_between_all(links);
  std::vector<RouteConfig> routes;
  std::set<std::pair<std::string, std::string>> pairs;
  for (const base::ConfigNode& node : overlaid_list(files, "routes", {"from", "to"})) {
    for (RouteConfig& route : parse_route(node, links)) {
      if (!pairs.insert({route.from, route.to}).second) {
        node.fail("there is another route from '" + route.from + "' to '" + route.to + "'");
      }
      routes.push_back(std::move(route));
    }
  }
  return routes;
}

}  // namespace

void pace_tight_lines(Topology& topology) {
  constexpr double kTight = 0.5;
  for (const LineBudget& budget : line_budgets(topology)) {
    if (budget.load_bytes_s() < kTight * budget.capacity_bytes_s) continue;
    for (LinkConfig& link : topology.links) {
      if (link.name == budget.link && link.pace) link.pace_pty = true;
    }
  }
}

std::string_view to_string(ThreadModel model) { return kThreadModels.word(model); }

Topology Topology::load(const std::filesystem::path& place) {
  return parse(load_topology_files(place));
}

Topology Topology::parse(const base::ConfigNode& root) { return parse(std::vector{root}); }

Topology Topology::parse(const std::vector<base::ConfigNode>& files) {
  for (const base::ConfigNode& file : files) {
    if (const int schema = file.require<int>("schema"); schema != kSchema) {
      file.at("schema").fail("schema " + std::to_string(schema) + " is not 1");
    }
    base::refuse_removed(
        file, {{"lock_memory", "memory is locked where `scheduling` has a fifo_priority"},
               {"route_lifetime_s",
                "a system is no target any more after 60 s of silence, one that sends "
                "HIGH_LATENCY2 after 200 s"}});
  }
  const base::ConfigNode root = overlaid(files);
  Topology topology = standard_topology();
  base::read_keys(root, kRestartKeys, topology);
  base::read_keys(root, kReloadKeys, topology);
  topology.links = parse_links(files, root, topology.command_port);
  topology.routes = parse_routes(files, root, topology.links);
  pace_tight_lines(topology);
  if (topology.pace == Pace::kLockstep) topology.set_lockstep();
  root.reject_unused();
  return topology;
}

bool Topology::runs_in_real_time() const {
  const auto has_priority = [](const LinkConfig& link) {
    return link.scheduling.fifo_priority.has_value();
  };
  return scheduling.fifo_priority || std::ranges::any_of(links, has_priority);
}

void Topology::set_lockstep() {
  constexpr base::Duration kNever = std::chrono::hours(24);
  pace = Pace::kLockstep;
  for (LinkConfig& link : links) {
    link.pace = false;
    link.queue.hil_max_age = link.queue.gps_max_age = kNever;
    link.queue.setpoint_max_age = link.queue.telemetry_max_age = kNever;
  }
}

std::vector<std::string> restart_keys(const Topology& in_force, const Topology& next) {
  std::vector<std::string> keys;
  base::for_each_key(kRestartKeys, [&](const auto& each) {
    if (each.of(in_force) != each.of(next)) keys.emplace_back(each.name);
  });
  if (!keys.empty()) return keys;

  // A field that no key sets is refused too: only these are known to change in place.
  Topology fixed = next;
  base::for_each_key(kReloadKeys, [&](const auto& each) { each.of(fixed) = each.of(in_force); });
  if (fixed != in_force) keys.emplace_back("topology");
  return keys;
}

void refuse_restart_keys(const Topology& in_force, const Topology& next,
                         const base::ConfigNode& root) {
  const std::vector<std::string> keys = restart_keys(in_force, next);
  if (keys.empty()) return;
  if (const auto node = root.find(keys.front())) node->fail("takes a restart");
  root.fail(keys.front() + ": takes a restart");  // the key was taken out
}

std::vector<base::KeyRow> restart_rows() {
  std::vector<base::KeyRow> rows;
  base::add_rows(kRestartKeys, standard_topology(), rows);
  return rows;
}

std::vector<base::KeyRow> reload_rows() {
  std::vector<base::KeyRow> rows;
  base::add_rows(kReloadKeys, standard_topology(), rows);
  return rows;
}

std::vector<std::string> changed_keys(const Topology& topology) {
  std::vector<std::string> changed;
  base::add_changed_keys(kRestartKeys, topology, standard_topology(), changed);
  base::add_changed_keys(kReloadKeys, topology, standard_topology(), changed);
  return changed;
}

}  // namespace cas::casd
