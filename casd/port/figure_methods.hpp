// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <utility>

#include "base/rpc/call_params.hpp"
#include "base/rpc/server.hpp"
#include "base/time/clock.hpp"
#include "casd/autopilot_log/autopilot_logs.hpp"
#include "casd/counters/echo_latency.hpp"
#include "casd/counters/link_counters.hpp"
#include "casd/counters/message_taps.hpp"
#include "casd/port/message_decoder.hpp"
#include "casd/port/metrics.hpp"
#include "casd/tlog/recorder.hpp"
#include "casd/topology/topology.hpp"

namespace cas::casd {

/// Sources of the figures.
struct FiguresSource {
  const LinkFigures* figures = nullptr;
  /// The topology in force; it changes on a reload.
  std::function<const Topology&()> topology;
  std::function<base::RunTime()> now;
  base::RunTime started{};
  /// Distinguishes this casd from others on the machine: a name, empty where it has none, and its
  /// topology's file.
  std::string name{};
  std::filesystem::path topology_file{};
  /// Whether a link was added at run time; without it none was.
  std::function<bool(const std::string& link)> is_added{};
  /// The `vehicles` of casd.status.
  std::function<nlohmann::json()> vehicles;
  /// The `recording` of casd.status; without it there is none.
  const Recorder* recorder = nullptr;
  /// The `autopilot_logs` of casd.status; without it no logs are taken.
  std::function<std::optional<AutopilotLogsStatus>()> autopilot_logs{};
  /// Where the newest packets of watched messages are; without it message.value is left out.
  MessageTaps* taps = nullptr;
  /// Where controllers' answers are timed; without it link.echo is empty.
  const EchoLatency* echo = nullptr;
  /// Names and values of messages, replaced on a reload.
  std::shared_ptr<const MessageDecoder> decoder = std::make_shared<const MessageDecoder>();
};

/// Result of a reload.
struct ReloadReport {
  base::RunTime at{};
  std::optional<std::string> trouble;  ///< why it was refused; nullopt: it is in force
};

/// The methods of the command port about casd itself: casd.status, link.*, message.* and
/// the topics `links`, `messages` and `drops`. Everything on the server's thread.
class FigureMethods {
 public:
  FigureMethods(base::rpc::Server& server, FiguresSource source);

  /// casd.status, also written to --stats FILE.
  nlohmann::json status() const;
  /// A copy of the figures for Prometheus.
  MetricsSource metrics_source() const;
  /// Replaces the dialect.
  void set_decoder(std::shared_ptr<const MessageDecoder> decoder);
  /// Keeps the outcome of the last reload for casd.status.
  void set_last_reload(ReloadReport reload) { last_reload_ = std::move(reload); }
  /// Source of message.value for packets that came before the first look; nullopt: none came.
  using Memory = std::function<std::optional<MessageTaps::Sample>(const MessageTaps::Key&)>;
  void set_memory(Memory memory) { memory_ = std::move(memory); }
  /// After each LinkFigures::sample: tells subscribers.
  void publish();

 private:
  nlohmann::json links() const;
  /// Which messages a client asks for.
  struct Wish {
    std::optional<std::string> link{};
    MessagePage page{};
  };
  Wish wish_of(base::rpc::CallParams& params) const;
  nlohmann::json messages(const Wish& wish) const;
  nlohmann::json value(base::rpc::CallParams& params) const;
  nlohmann::json routes() const;
  nlohmann::json drops(Wish wish) const;
  nlohmann::json unreadable(const std::optional<std::string>& only) const;
  nlohmann::json latency() const;
  nlohmann::json echo() const;
  std::string message_name(std::uint32_t id) const;
  std::string link_name(LinkId id) const;
  void publish_link_changes();
  void publish_drops();
  std::uint32_t asked_message(const nlohmann::json& message) const;
  LinkId require_link(const std::string& name) const;

  base::rpc::Server& server_;
  FiguresSource source_;
  std::map<std::string, std::string> last_states_;
  std::uint64_t last_dropped_ = 0;
  std::optional<ReloadReport> last_reload_;  ///< nullopt: none yet
  Memory memory_;
};

}  // namespace cas::casd
