// SPDX-License-Identifier: BSD-3-Clause
#include "casd/casctl/session/session.hpp"

#include <fmt/format.h>
#include <cmath>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <nlohmann/json_fwd.hpp>
#include <sstream>
#include <thread>
#include <utility>
#include <vector>

#include "base/byte_order_mark.hpp"
#include "base/error.hpp"
#include "base/os/host_port.hpp"
#include "base/rpc/local_clients.hpp"
#include "base/rpc/local_port.hpp"
#include "base/rpc/token.hpp"
#include "base/text.hpp"
#include "casd/casctl/session/port_owner.hpp"
#include "casd/casctl/session/text.hpp"

namespace cas::casctl {
namespace {

using nlohmann::json;

/// A casd that hangs must not keep the list waiting.
constexpr base::Duration kPatience = std::chrono::seconds(2);

json daemon(base::rpc::LocalClient& local) {
  json entry{{"address", local.address}};
  try {
    const json status = local.client.call("casd.status", json::object(), kPatience);
    for (const char* key : {"name", "topology", "uptime_s"}) {
      if (status.contains(key)) entry[key] = status[key];
    }
    entry["vehicles"] = json::array();
    for (const json& vehicle : status.value("vehicles", json::array())) {
      entry["vehicles"].push_back(vehicle.value("system", 0));
    }
  } catch (const std::runtime_error& error) {
    entry["trouble"] = error.what();
  }
  return entry;
}

/// In this place's time: "2026-11-22 18:05:00".
std::string clock_text(double since_1970_s) {
  const auto seconds = static_cast<std::time_t>(since_1970_s);
  std::tm parts{};
  char text[32];
  if (::localtime_r(&seconds, &parts) == nullptr) return "?";
  return {text, std::strftime(text, sizeof text, "%F %T", &parts)};
}

std::string vehicles_text(const json& daemon) {
  const json vehicles = daemon.value("vehicles", json::array());
  if (vehicles.empty()) return "none";
  return base::joined(vehicles, ", ", [](const json& system) { return system.dump(); });
}

/// Several casds as a table: address, topology, vehicles and start of each.
/// @param daemons  as SeveralDaemons has them
/// @param now_s  the system's clock, s since 1970
std::string daemon_table(const json& daemons, double now_s) {
  Table table({"address", "runs", "vehicles", "since"});
  for (const json& each : daemons) {
    const std::string address = each.value("address", "");
    if (!each.contains("uptime_s")) {
      table.add({address, "does not answer", "?", "?"});
      continue;
    }
    table.add({address, each.value("name", each.value("topology", "endpoints of its command line")),
               vehicles_text(each), clock_text(now_s - each.value("uptime_s", 0.0))});
  }
  std::ostringstream text;
  table.print(text);
  return text.str();
}

/// Asks each casd for its topology and throws the list of them.
void throw_several(std::vector<base::rpc::LocalClient>& clients) {
  json daemons = json::array();
  for (base::rpc::LocalClient& client : clients) daemons.push_back(daemon(client));
  const double now_s =
      std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
  std::string text =
      fmt::format("{} casds run on this machine: say which with --address or CASD_ADDRESS\n{}",
                  clients.size(), daemon_table(daemons, now_s));
  text.pop_back();
  throw SeveralDaemons(text, std::move(daemons));
}

constexpr auto kPollPeriod = std::chrono::milliseconds(100);
const std::string kTcpAddress = fmt::format("127.0.0.1:{}", base::rpc::kCommandPort);

std::string first_line(const std::filesystem::path& file) {
  std::ifstream in(file);
  std::string line;
  if (!std::getline(in, line)) {
    throw std::runtime_error("cannot read a token from " + file.string() +
                             "; check the file's rights");
  }
  return std::string(base::trimmed(base::without_byte_order_mark(line)));
}

std::chrono::steady_clock::time_point deadline(const Options& options) {
  return std::chrono::steady_clock::now() +
         std::chrono::duration_cast<std::chrono::steady_clock::duration>(
             std::chrono::duration<double>(options.timeout_s));
}

}  // namespace

Session::Session(const Options& options)
    : options_(options), give_up_(deadline(options)), client_(connect()) {
  options_.address = address_;  // a session made from these options goes to the same casd
  authorise();
}

/// With --wait casd may be just starting.
base::rpc::Client Session::connect() {
  for (;;) {
    try {
      if (options_.address.empty()) return connect_here();
      address_ = options_.address;
      return base::rpc::Client(address_);
    } catch (const base::rpc::ConnectionError&) {
      if (!may_wait()) throw;
    }
    wait_because("casd does not answer at " + address_ + " yet", kPollPeriod);
  }
}

base::rpc::Client Session::connect_here() {
  std::vector<base::rpc::LocalClient> clients = base::rpc::connect_local();
  if (clients.size() > 1) throw_several(clients);
  if (clients.size() == 1) {
    address_ = clients.front().address;
    return std::move(clients.front().client);
  }
  address_ = kTcpAddress;
  return base::rpc::Client(address_);
}

void Session::authorise() {
  if (!options_.token_file.empty()) {
    client_.call("authorise", json{{"token", first_line(options_.token_file)}});
    return;
  }
  // A token of this machine must not reach another one.
  const std::optional<base::HostPort> tcp = base::parse_host_port(address_);
  if (address_.starts_with("unix:") || !tcp || !base::rpc::is_loopback_address(tcp->host)) return;
  if (is_asked_for_token()) return authorise_with_own_token();
  if (is_own_port(tcp->port)) return;
  throw base::rpc::CallError(base::rpc::kNotAuthorised,
                             "what listens at " + address_ +
                                 " is another user's program and asks for no token, by which casd "
                                 "would prove itself, so nothing was sent to it: take casd's Unix "
                                 "socket, or give --token-file",
                             "null");
}

/// Whether casd wants a token of TCP clients of this machine.
bool Session::is_asked_for_token() {
  try {
    client_.call("methods", json::object());
    return false;
  } catch (const base::rpc::CallError& error) {
    return error.code() == base::rpc::kNotAuthorised;
  }
}

/// With the tokens that casd has on this machine. The listener at a TCP port of this machine may be
/// any program: the token is not sent, and no proof to one that does not prove itself.
void Session::authorise_with_own_token() {
  const std::vector<std::filesystem::path> files = base::rpc::local_command_tokens();
  std::vector<std::string> tokens;
  std::string names;
  for (const std::filesystem::path& file : files) {
    try {  // one that could be guessed would prove nothing
      tokens.push_back(base::rpc::read_token(file));
      names += (names.empty() ? "" : " or ") + file.string();
    } catch (const base::ConfigError&) {
      if (file == files.back() && tokens.empty()) throw;
    }
  }
  if (tokens.empty()) return;
  try {
    if (client_.authorise_by_proof(tokens)) return;
  } catch (const base::rpc::CallError& error) {
    if (error.code() != base::rpc::kInvalidParams) throw;  // else it is an older casd
  }
  throw base::rpc::CallError(base::rpc::kNotAuthorised,
                             "what listens at " + address_ +
                                 " did not prove that it knows the token in " + names +
                                 ", so it was not told it: it has another token, is an older casd, "
                                 "or is no casd",
                             "null");
}

bool Session::may_wait() const {
  return options_.wait && std::chrono::steady_clock::now() < give_up_;
}

void Session::wait_because(const std::string& reason, std::chrono::milliseconds period) {
  if (!options_.json && reason != told_)
    std::cerr << "casctl: waiting: " << printable_lines(reason) << '\n';
  told_ = reason;
  std::this_thread::sleep_for(period);
}

json Session::call(const std::string& method, const json& params) {
  return client_.call(method, params, base::from_seconds(options_.timeout_s));
}

json Session::vehicle_call(const std::string& method, json params) {
  if (options_.vehicle) params["vehicle"] = *options_.vehicle;
  for (;;) {
    try {
      return call(method, params);
    } catch (const base::rpc::CallError& error) {
      if (error.code() != base::rpc::kNoSuchVehicle || !may_wait()) throw;
      wait_because(error.what(), kPollPeriod);
    }
  }
}

json Session::list_params(int vehicle) {
  try {
    call("subscribe", {{"topic", "parameters"}});
  } catch (const base::rpc::CallError&) {  // an older casd does not tell
  }
  const auto show = [this](const std::string& method, const json& progress) {
    if (method != "parameters" || options_.json) return;
    const auto count = progress.value("count", 0);
    std::cerr << "casctl: " << progress.value("received", 0) << " of "
              << (count == 0 ? "?" : std::to_string(count)) << " parameters\n";
  };
  return client_.call("param.list", {{"vehicle", vehicle}}, base::from_seconds(options_.timeout_s),
                      show);
}

namespace {

/// Advice on a state that does not come.
std::string advice(const std::string& what, const json& state) {
  if (is_silent(state)) {
    const double age_s = state.value("heartbeat_age_s", 0.0);
    return fmt::format("; no HEARTBEAT has come for {} s: look at `casctl links`",
                       std::lround(age_s));
  }
  const bool needs_arming = what != "disarmed" && what != "landed";
  if (needs_arming && !state.value("armed", true)) {
    return "; it is disarmed: arm it with `casctl arm --wait`";
  }
  return "; look at `casctl status`, or give a longer --timeout";
}

}  // namespace

json Session::wait_for(const std::string& what, const OfState& reached) {
  auto [state, came] = wait_at_most(std::chrono::duration<double>(options_.timeout_s), reached);
  if (came) return std::move(state);
  throw WaitTimeout("acknowledged, but the vehicle was not heard to be " + what + " within " +
                    json(options_.timeout_s).dump() + " s" + advice(what, state));
}

std::pair<json, bool> Session::wait_at_most(std::chrono::duration<double> patience,
                                            const OfState& reached) {
  const auto give_up = std::chrono::steady_clock::now() + patience;
  for (;;) {
    json state = vehicle_call("vehicle.state");
    if (reached(state)) return {std::move(state), true};
    if (std::chrono::steady_clock::now() > give_up) return {std::move(state), false};
    std::this_thread::sleep_for(kPollPeriod);
  }
}

json all_messages(Session& session) {
  constexpr std::size_t kPage = 5000;        // rows of an answer
  constexpr std::size_t kMost = 20 * kPage;  // enough to judge by, whatever floods casd
  json all = session.call("message.list");
  for (std::size_t rows = all.size(); rows == kPage && all.size() < kMost;) {
    json page = session.call("message.list", {{"offset", all.size()}});
    rows = page.size();
    for (json& row : page) all.push_back(std::move(row));
  }
  return all;
}

bool is_silent(const json& vehicle) {
  constexpr double kFresh_s = 3;  // of a casd that does not say after which time
  return vehicle.value("heartbeat_age_s", 0.0) > vehicle.value("silent_after_s", kFresh_s);
}

bool printed_as_json(const Options& options, const json& result) {
  if (options.json) {
    std::cout << result.dump(-1, ' ', true, json::error_handler_t::replace)
              << '\n';  // ASCII: no order to a terminal
  }
  return options.json;
}

void report(const Options& options, const json& result, const std::string& sentence) {
  if (!printed_as_json(options, result)) std::cout << printable_lines(sentence) << '\n';
}

}  // namespace cas::casctl
