// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "base/os/thread.hpp"
#include "base/rpc/local_port.hpp"
#include "base/time/clock.hpp"
#include "casd/packet/own_station.hpp"
#include "casd/queue/line_timing.hpp"
#include "casd/routing/router.hpp"
#include "casd/tlog/recorder.hpp"
#include "casd/topology/link_config.hpp"
#include "casd/topology/route_config.hpp"
#include "mavlink_gen/runtime/packet.hpp"

namespace cas::base {
class ConfigNode;
struct KeyRow;
}  // namespace cas::base

namespace cas::casd {

enum class ThreadModel : std::uint8_t {
  kAuto,      ///< one thread, and one more for each link that floods
  kPerLink,   ///< each link has its own thread
  kSingle,    ///< one event loop
  kBlocking,  ///< one thread that forwards everything and waits for the line: the paper's TS
};
std::string_view to_string(ThreadModel model);

/// The clock of casd's own station: heartbeats, retries, ages.
enum class Pace : std::uint8_t {
  kRealtime,  ///< the steady clock
  kLockstep,  ///< the time stamps of the HIL_SENSOR stream
};

/// Addresses of the command port, and who may use it.
struct CommandPortConfig {
  std::string address = "127.0.0.1";
  std::uint16_t port = base::rpc::kCommandPort;
  /// Nothing: casd.sock in the runtime folder, unless the port is 0. Empty: none.
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

/// Settings of casd's own station: its messages and its consents.
struct CommandingConfig {
  double heartbeat_hz = 1;
  bool allow_not_hil = false;  ///< consent to arm a vehicle that is not in HIL
  bool ask_on_sight = true;    ///< see CommanderOptions; never in lockstep

  friend bool operator==(const CommandingConfig&, const CommandingConfig&) = default;
};

/// casd's whole configuration ("TOPOLOGY.yaml", schema 1).
struct Topology {
  mav::Source self = kOwnStation;
  ThreadModel threads = ThreadModel::kAuto;
  base::Duration drain_tick = LineDrain::kDefaultTick;  ///< threads: blocking
  Pace pace = Pace::kRealtime;
  base::ThreadOptions scheduling;         ///< of all link threads, unless a link has its own
  bool seek_core = true;                  ///< CoreSeeker
  std::optional<int> cpu_dma_latency_us;  ///< base::CpuLatencyRequest
  base::Duration duplicate_window{};      ///< RoutingPlan::duplicate_window
  CommandPortConfig command_port;
  std::optional<MetricsConfig> metrics;  ///< nothing: no HTTP port
  CommandingConfig commanding;
  std::vector<LinkConfig> links;
  std::vector<RouteConfig> routes;
  TlogConfig log;
  std::filesystem::path dialect;  ///< MAVLink XML beside the generated dialect; empty: none
  std::filesystem::path gains;    ///< empty: none; loop name -> parameter names per autopilot

  /// Reads a file with what overlays it, or a folder: load_topology_files().
  /// @throws ConfigError "FILE:LINE: key: sentence"
  static Topology load(const std::filesystem::path& place);
  static Topology parse(const base::ConfigNode& root);
  /// Reads files that overlay each other, see overlaid(): links by their names, routes by their
  /// ends.
  static Topology parse(const std::vector<base::ConfigNode>& files);

  /// Puts `pace` to lockstep. Its lines are not paced and nothing in a queue grows old: simulated
  /// time stands still meanwhile.
  void set_lockstep();
  /// Whether a link thread has a real-time priority; casd then locks its memory, too.
  bool runs_in_real_time() const;

  friend bool operator==(const Topology&, const Topology&) = default;
};

/// Keys whose values differ and that a running casd cannot change: all but `links`, `routes`,
/// `duplicate_window_ms`, `commanding`, `dialect` and `gains`. Empty: a reload puts `next` in
/// force.
std::vector<std::string> restart_keys(const Topology& in_force, const Topology& next);

/// The same with the place in the file. @throws base::ConfigError "FILE:LINE: key: sentence"
void refuse_restart_keys(const Topology& in_force, const Topology& next,
                         const base::ConfigNode& root);

/// Paces pseudo-terminals, which have no rate of their own, at their baud rate if the routes may
/// send half of it or more: only then does the rate change the age of the data.
void pace_tight_lines(Topology& topology);

/// The keys of a topology, its links and routes left out, whose value is not the default.
std::vector<std::string> changed_keys(const Topology& topology);

/// Keys of a topology that a restart alone changes.
std::vector<base::KeyRow> restart_rows();
/// Keys that a reload puts in force.
std::vector<base::KeyRow> reload_rows();
}  // namespace cas::casd
