// SPDX-License-Identifier: BSD-3-Clause
#include "casd/casctl/session/daemon_list.hpp"

#include <fmt/format.h>
#include <chrono>
#include <ctime>
#include <nlohmann/json.hpp>
#include <sstream>

#include "base/text.hpp"
#include "casd/casctl/session/session.hpp"
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

}  // namespace

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

}  // namespace cas::casctl
