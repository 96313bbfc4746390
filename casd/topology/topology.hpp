// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "base/os/thread.hpp"
#include "base/time/clock.hpp"
#include "casd/queue/line_timing.hpp"
#include "casd/routing/router.hpp"
#include "casd/tlog/recorder.hpp"
#include "casd/topology/link_config.hpp"
#include "mavlink_gen/runtime/packet.hpp"

namespace cas::base {
class ConfigNode;
struct KeyRow;
}  // namespace cas::base

namespace cas::casd {

/// One entry of `routes`, with the names of its links.
struct RouteConfig {
  std::string from;
  std::string to;
  ForwardRule rule;  ///< its link ids are filled in by make_plan()

  friend bool operator==(const RouteConfig&, const RouteConfig&) = default;
};

enum class ThreadModel : std::uint8_t {
  kPerLink,   ///< each link has its own thread
  kSingle,    ///< one event loop
  kBlocking,  ///< one thread that forwards everything and waits for the line: the paper's TS
};
std::string_view to_string(ThreadModel model);

/// Whose time casd's own station runs on: heartbeats, retries, ages.
enum class Pace : std::uint8_t {
  kRealtime,  ///< the steady clock
  kLockstep,  ///< the HIL_SENSOR stream that passes
};

struct CommandPortConfig {
  std::string address = "127.0.0.1";
  std::uint16_t port = 5790;
  /// Nothing: casd.sock in the runtime folder, where the port is not 0. Empty: none.
  std::optional<std::filesystem::path> unix_path;
  std::string unix_group;            ///< whose members may connect to the Unix socket; empty: none
  std::filesystem::path token_file;  ///< empty: casd.token in the state or runtime folder
  bool loopback_without_token = false;  ///< TCP clients of this machine need no token

  friend bool operator==(const CommandPortConfig&, const CommandPortConfig&) = default;
};

/// Figures over HTTP (`metrics`).
struct MetricsConfig {
  std::string address = "127.0.0.1";
  std::uint16_t port = 9790;  ///< 0 takes a free one

  friend bool operator==(const MetricsConfig&, const MetricsConfig&) = default;
};

struct CommandingConfig {
  double heartbeat_hz = 1;
  bool allow_not_hil = false;  ///< consent to arm a vehicle that is not in HIL

  friend bool operator==(const CommandingConfig&, const CommandingConfig&) = default;
};

/// casd's whole configuration ("TOPOLOGY.yaml", schema 1).
struct Topology {
  mav::Source self{254, 190};
  ThreadModel threads = ThreadModel::kPerLink;
  base::Duration drain_tick = LineDrain::kDefaultTick;  ///< threads: blocking
  Pace pace = Pace::kRealtime;
  base::ThreadOptions scheduling;  ///< of all link threads, unless a link has its own
  bool lock_memory = false;
  std::optional<int> cpu_dma_latency_us;  ///< base::CpuLatencyRequest
  base::Duration route_lifetime = Router::kRouteLifetime;
  CommandPortConfig command_port;
  std::optional<MetricsConfig> metrics;  ///< nothing: no HTTP port
  CommandingConfig commanding;
  std::vector<LinkConfig> links;
  std::vector<RouteConfig> routes;
  TlogConfig log;
  std::filesystem::path dialect;  ///< MAVLink XML beside the generated dialect; empty: none
  std::filesystem::path gains;    ///< empty: none; loop name -> parameter names per autopilot

  /// Of a file with what overlays it, or of a folder: load_topology_files().
  /// @throws ConfigError "FILE:LINE: key: sentence"
  static Topology load(const std::filesystem::path& place);
  static Topology parse(const base::ConfigNode& root);
  /// Of files that overlay each other, see overlaid(): links by their names, routes by their ends.
  static Topology parse(const std::vector<base::ConfigNode>& files);

  /// Puts `pace` to lockstep. Its lines are not paced and nothing in a queue grows old: simulated
  /// time stands still meanwhile.
  void set_lockstep();

  friend bool operator==(const Topology&, const Topology&) = default;
};

/// Keys whose values differ and that a running casd cannot change: all but `links`, `routes`,
/// `commanding`, `dialect` and `gains`. Empty: a reload puts `next` in force.
std::vector<std::string> restart_keys(const Topology& in_force, const Topology& next);

/// The same with the place in the file. @throws base::ConfigError "FILE:LINE: key: sentence"
void refuse_restart_keys(const Topology& in_force, const Topology& next,
                         const base::ConfigNode& root);

/// The routes of one entry of `routes`: `from` and `to` take a name, a list of names or `any`.
/// @throws base::ConfigError
std::vector<RouteConfig> parse_route(const base::ConfigNode& node,
                                     const std::vector<LinkConfig>& links);
/// Those of a topology without `routes`: every link talks to every other one.
std::vector<RouteConfig> routes_between_all(const std::vector<LinkConfig>& links);

/// A pseudo-terminal has no rate of its own. It is held to its baud rate where that makes a
/// difference to how old data gets: where the routes may send half of it or more.
void pace_tight_lines(Topology& topology);

/// A route's filters as `casd --check` tells them: "only HIL_SENSOR, not systems 2".
std::string rule_text(const ForwardRule& rule);

/// Keys of a topology that a restart alone changes.
std::vector<base::KeyRow> restart_rows();
/// Keys that a reload puts in force.
std::vector<base::KeyRow> reload_rows();
/// Keys of one entry of `routes`.
std::vector<base::KeyRow> route_rows();

}  // namespace cas::casd
