// SPDX-License-Identifier: BSD-3-Clause
#include "hils/boards/board_session.hpp"

#include <fmt/format.h>

#include <array>
#include <chrono>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "base/os/write_file.hpp"
#include "base/rpc/client.hpp"
#include "hils/boards/board_error.hpp"
#include "hils/run/run_paths.hpp"
#include "mavlink/common/autopilot_version.hpp"
#include "mavlink/common/enums.hpp"

namespace cas::hils {

namespace {

using base::rpc::Json;

constexpr const char* kLink = "fcu";
constexpr double kFreshHeartbeat_s = 3;
constexpr base::Duration kStopPatience = std::chrono::seconds(5);

/// JSON is YAML, too.
std::string topology(const Board& board, const std::filesystem::path& device,
                     std::uint16_t peer_port, const RunDirectory& folder) {
  Json json{{"schema", 1},
            {"command_port",
             {{"address", "127.0.0.1"},
              {"port", 0},
              {"unix", folder.command_socket().string()},
              {"token_file", (folder.path() / "casd.token").string()}}},
            {"links", Json::array({{{"name", kLink},
                                    {"type", "serial"},
                                    {"device", device.string()},
                                    {"baud", board.baud},
                                    {"unlocked_pty", true}}})},
            {"commanding", {{"heartbeat_hz", 1}}}};
  if (peer_port != 0) {
    json["links"].push_back(
        {{"name", "peer"}, {"type", "udp"}, {"remote", fmt::format("127.0.0.1:{}", peer_port)}});
    json["routes"] =
        Json::array({{{"from", kLink}, {"to", "peer"}}, {{"from", "peer"}, {"to", kLink}}});
  }
  return json.dump();
}

/// The field of a message as `message.value` answers; null when it is not there.
Json field_of(const Json& answer, const char* name) {
  if (!answer.at("fields").is_array()) return nullptr;
  for (const Json& field : answer.at("fields")) {
    if (field.at("name") == name) return field.at("value");
  }
  return nullptr;
}

std::optional<double> uptime_of(const Json& system_time) {
  const Json boot_ms = field_of(system_time, "time_boot_ms");
  if (!boot_ms.is_number()) return std::nullopt;
  return 1e-3 * boot_ms.get<double>();
}

}  // namespace

struct BoardSession::Impl {
  Impl(Supervisor& owner, const Board& its, std::filesystem::path path, std::uint16_t peer_port)
      : supervisor(owner), board(its), device(std::move(path)) {
    const std::filesystem::path config = folder.path() / "casd.yaml";
    base::write_file(config, topology(board, device, peer_port, folder), base::Durability::kCache);
    casd = &supervisor.start(
        {.name = "casd",
         .arguments = {sibling_program("casd"), config.string(), "--name", board.name},
         .log_file = folder.path() / "casd.log",
         .notify_socket = folder.path() / "casd.notify"},
        Supervisor::kReadyTimeout);
    client.emplace("unix:" + folder.command_socket().string());
  }
  ~Impl() {
    client.reset();
    try {
      supervisor.stop(*casd, kStopPatience);
    } catch (...) {  // the supervisor has ended it
    }
  }

  Json message(const char* name) {
    return client->call(
        "message.value",
        {{"link", kLink}, {"message", name}, {"system", system}, {"component", component}});
  }
  void read_commit(BoardFacts& facts) {
    const Json bytes = field_of(message("AUTOPILOT_VERSION"), "flight_custom_version");
    std::array<std::uint8_t, 8> custom{};
    if (!bytes.is_array() || bytes.size() != custom.size()) return;
    for (std::size_t i = 0; i < custom.size(); ++i) custom[i] = bytes[i].get<std::uint8_t>();
    facts.commit = commit_text(custom, facts.autopilot);
  }

  Supervisor& supervisor;
  const Board& board;
  std::filesystem::path device;
  RunDirectory folder;
  ChildProcess* casd = nullptr;
  std::optional<base::rpc::Client> client;
  int system = 0;  ///< of the autopilot, once it has been heard
  int component = 0;
};

BoardSession::BoardSession(Supervisor& supervisor, const Board& board, std::filesystem::path device,
                           std::uint16_t peer_port)
    : impl_(std::make_unique<Impl>(supervisor, board, std::move(device), peer_port)) {}
BoardSession::~BoardSession() = default;

const std::filesystem::path& BoardSession::device() const { return impl_->device; }

BoardFacts BoardSession::look() {
  BoardFacts facts{.device = impl_->device};
  const Json status = impl_->client->call("casd.status", Json::object());
  const Json& link = status.at("links").at(0);
  facts.link_up = link.value("state", "") == "up";
  facts.link_words = link.value("endpoint", "");
  try {
    const Json state = impl_->client->call("vehicle.state", Json::object());
    facts.heard = state.value("heartbeat_age_s", 0.0) < kFreshHeartbeat_s;
    facts.armed = state.value("armed", false);
    facts.hil = state.value("hil", false);
    facts.autopilot = state.value("autopilot", "");
    facts.firmware = state.value("firmware", "");
    impl_->system = state.value("system", 0);
    impl_->component = state.value("component", 0);
    if (!facts.firmware.empty()) impl_->read_commit(facts);
  } catch (const base::rpc::CallError& error) {
    if (error.code() != base::rpc::kNoSuchVehicle) throw;
  }
  return facts;
}

void BoardSession::ask_version() {
  using mavlink::common::AutopilotVersion;
  using mavlink::common::MavCmd;
  try {
    impl_->client->call("vehicle.command", {{"command", static_cast<int>(MavCmd::kRequestMessage)},
                                            {"params", Json::array({AutopilotVersion::kId})}});
  } catch (const base::rpc::CallError&) {
    // The caller waits for the message itself.
  }
}

std::optional<double> BoardSession::uptime_s() {
  if (impl_->system == 0) return std::nullopt;
  return uptime_of(impl_->message("SYSTEM_TIME"));
}

std::optional<base::RunTime> BoardSession::began() {
  if (impl_->system == 0) return std::nullopt;
  const Json time = impl_->message("SYSTEM_TIME");
  const std::optional<double> uptime_s = uptime_of(time);
  const auto age_s = time.find("age_s");
  if (!uptime_s || age_s == time.end() || !age_s->is_number()) return std::nullopt;
  return base::steady_now() - base::from_seconds(*uptime_s + age_s->get<double>());
}

void BoardSession::disarm() {
  try {
    impl_->client->call("vehicle.disarm", {{"force", true}});
  } catch (const base::rpc::CallError& error) {
    throw BoardError(kExitBoardFailed, fmt::format("board '{}' is armed and did not disarm: {}",
                                                   impl_->board.name, error.what()));
  }
}

casd::ParamValues BoardSession::params() {
  constexpr base::Duration kPatience = std::chrono::minutes(3);
  try {
    const Json list = impl_->client->call("param.list", Json::object(), kPatience);
    casd::ParamValues values;
    for (const Json& param : list.at("parameters")) {
      if (param.at("value").is_number()) values[param.at("name")] = param["value"];
    }
    return values;
  } catch (const base::rpc::CallError& error) {
    throw BoardError(kExitBoardFailed, fmt::format("board '{}' did not tell its parameters: {}",
                                                   impl_->board.name, error.what()));
  }
}

void BoardSession::set_param(const std::string& name, double value) {
  try {
    const Json answer = impl_->client->call("param.set", {{"name", name}, {"value", value}});
    if (answer.at("value") == value) return;
    throw BoardError(kExitBoardFailed, fmt::format("board '{}': {} stays {}", impl_->board.name,
                                                   name, answer.at("value").dump()));
  } catch (const base::rpc::CallError& error) {
    throw BoardError(kExitBoardFailed, fmt::format("board '{}' did not take {} {:g}: {}",
                                                   impl_->board.name, name, value, error.what()));
  }
}

void BoardSession::reboot() {
  try {
    impl_->client->call("vehicle.reboot", Json::object());
  } catch (const base::rpc::CallError& error) {
    throw BoardError(kExitBoardFailed, fmt::format("board '{}' did not take the restart: {}",
                                                   impl_->board.name, error.what()));
  }
}

}  // namespace cas::hils
