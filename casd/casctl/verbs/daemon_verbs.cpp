// SPDX-License-Identifier: BSD-3-Clause
#include <chrono>
#include <iostream>
#include <map>
#include <memory>
#include <thread>

#include "base/rpc/client.hpp"
#include "base/text.hpp"
#include "casd/casctl/session/text.hpp"
#include "casd/casctl/verbs/verbs.hpp"

namespace cas::casctl {
namespace {

using nlohmann::json;

bool is_up(const json& link) { return link.value("state", "") == "up"; }

/// Why links are not up, a sentence that would make the table's column wide.
void print_troubles(const json& links) {
  for (const json& link : links) {
    if (is_up(link)) continue;
    std::cout << "link " << printable(link.value("name", "?")) << " is " << link.value("state", "?")
              << ": " << printable(endpoint_text(link)) << '\n';
  }
}

/// Properties of links that have no column: sniffers, groups, added at run time.
void print_kinds(const json& links) {
  std::map<std::string, std::vector<std::string>> kinds;
  for (const json& link : links) {
    const std::string name = link.value("name", "?");
    if (link.value("sniffer", false))
      kinds["sniffer, gets every packet and takes in nothing: "].push_back(name);
    if (link.contains("group"))
      kinds["paths of group " + link.value("group", "?") + ": "].push_back(name);
    if (link.value("added", false)) {
      kinds["added at run time, ended by a reload of a topology without it: "].push_back(name);
    }
  }
  for (const auto& [kind, names] : kinds) {
    std::cout << printable(kind) << printable(base::joined(names, ", ")) << '\n';
  }
}

void print_links(const json& links) {
  std::vector<std::string> columns{"LINK", "TYPE", "STATE", "ENDPOINT"};
  for (const casd::CounterWords& words : casd::kLinkCounters) {
    if (!words.column.empty()) columns.emplace_back(words.column);
  }
  Table table(std::move(columns));
  for (const json& link : links) {
    std::vector<std::string> cells{link.value("name", "?"), link.value("type", "?"),
                                   link.value("state", "?"),
                                   is_up(link) ? endpoint_text(link) : "-"};
    for (const casd::CounterWords& words : casd::kLinkCounters) {
      if (words.column.empty()) continue;
      const std::optional<std::uint64_t> value = counter_of(link, words);
      cells.push_back(value ? std::to_string(*value) : "-");
    }
    table.add(std::move(cells));
  }
  table.print(std::cout);
  print_troubles(links);
  print_kinds(links);
}

void print_vehicles(const json& vehicles) {
  Table table(
      {"VEHICLE", "AUTOPILOT", "TYPE", "ARMED", "HIL", "MODE", "LANDED", "LINK", "HEARTBEAT"});
  for (const json& vehicle : vehicles) {
    table.add({count_text(vehicle, "system"), vehicle.value("autopilot", "?"),
               vehicle.value("type", "?"), vehicle.value("armed", false) ? "armed" : "no",
               vehicle.value("hil", false) ? "yes" : "NO", vehicle.value("mode", "?"),
               vehicle.value("landed", "?"), vehicle.value("link", "?"),
               duration_text(vehicle.value("heartbeat_age_s", 0.0)) + " ago" +
                   (is_silent(vehicle) ? " (SILENT)" : "")});
  }
  if (table.empty()) {
    std::cout << "no vehicle heard yet: is its link up, and does it send HEARTBEAT?\n";
  } else {
    table.print(std::cout);
  }
  for (const json& vehicle : vehicles) {
    for (const json& complaint : vehicle.value("complaints", json::array())) {
      std::cout << "vehicle " << count_text(vehicle, "system") << ": "
                << printable(complaint.get<std::string>()) << '\n';
    }
  }
}

/// The topology on the disk is not the one in force.
void print_reload(const json& status) {
  const json reload = status.value("reload", json::object());
  if (reload.value("accepted", true)) return;
  std::cout << "the last reload, " << duration_text(reload.value("age_s", 0.0))
            << " ago, was refused: " << printable_lines(reload.value("reason", "?")) << '\n';
}

/// Senders whose signatures come from the future.
void print_future(const json& links) {
  for (const json& link : links) {
    const json future = link.value("signing", json::object()).value("future", json::object());
    if (future.value("ahead_s", 0.0) <= 0) continue;
    std::cout << "link " << link.value("name", "?") << ": " << stream_text(future) << " signs "
              << duration_text(future.value("ahead_s", 0.0)) << " ahead of the clock"
              << (future.value("refused", false) ? " and is refused\n" : "\n");
  }
}

void print_status(const json& status) {
  std::cout << "casd " << status.value("version", "?") << ", up "
            << duration_text(status.value("uptime_s", 0.0)) << ", threads "
            << status.value("threads", "?") << "\n";
  print_reload(status);
  std::cout << '\n';
  print_links(status.value("links", json::array()));
  std::cout << '\n';
  print_vehicles(status.value("vehicles", json::array()));
  print_future(status.value("links", json::array()));
  const std::string recording = recording_text(status.value("recording", json::object()));
  if (!recording.empty()) std::cout << '\n' << recording << '\n';
  if (const auto logs = status.find("autopilot_logs"); logs != status.end()) {
    std::cout << '\n' << autopilot_logs_text(*logs) << '\n';
  }
}

std::string joined(const json& list) {
  return base::joined(list, " ", [](const json& item) {
    return item.is_string() ? item.get<std::string>() : item.dump();
  });
}

/// "only HIL_SENSOR HIL_GPS; at most ATTITUDE 10 Hz".
std::string rule_text(const json& route) {
  std::string text;
  const auto add = [&text](const std::string& part) { text += (text.empty() ? "" : "; ") + part; };
  if (route.contains("allow")) add("only " + joined(route["allow"]));
  if (route.contains("block")) add("not " + joined(route["block"]));
  for (const auto& [key, words] : {std::pair{"allow_systems", "only from systems "},
                                   {"block_systems", "not from systems "},
                                   {"allow_components", "only from components "},
                                   {"block_components", "not from components "}}) {
    if (route.contains(key)) add(words + joined(route[key]));
  }
  for (const json& rate : route.value("rates", json::array())) {
    std::string limit = joined(json::array({rate.at("message")}));
    if (rate.contains("max_hz")) limit += " at most " + fixed(rate["max_hz"], 1) + " Hz";
    if (rate.contains("every")) limit += " every " + rate["every"].dump() + "th";
    add(limit);
  }
  return text.empty() ? "everything" : text;
}

int show_routes(Session& session) {
  const json routes = session.call("link.routes");
  if (printed_as_json(session.options(), routes)) return kDone;
  Table table({"FROM", "TO", "WHAT"});
  for (const json& route : routes) {
    table.add({route.value("from", "?"), route.value("to", "?"), rule_text(route)});
  }
  table.print(std::cout);
  return kDone;
}

int show_latency(Session& session) {
  const json all = session.call("link.latency");
  if (printed_as_json(session.options(), all)) return kDone;
  Table table({"TO LINK", "P50 us", "P99 us", "MAX us"});
  for (const json& entry : all) {
    const bool sent = entry.value("max", 0.0) > 0;
    const auto cell = [&](const char* key) { return sent ? fixed(entry.value(key, 0.0), 0) : "-"; };
    table.add({entry.value("link", "?"), cell("p50"), cell("p99"), cell("max")});
  }
  table.print(std::cout);
  std::cout << "from read on one link to written on the other\n";
  for (const json& echo : session.call("link.echo")) {
    if (echo.at("count") == 0) {
      std::cout << "vehicle " << echo.at("vehicle") << ": none of its " << echo.at("unmatched")
                << " controls carries the stamp of a HIL_SENSOR that casd saw, so their delay is "
                   "unknown (stock firmware on a line stamps them with its own clock)\n";
      continue;
    }
    std::cout << "vehicle " << echo.at("vehicle") << " answers HIL_SENSOR after "
              << fixed(echo.value("p50", 0.0), 0) << " us (p99 " << fixed(echo.value("p99", 0.0), 0)
              << ", " << echo.at("count") << " answers, " << echo.at("unmatched")
              << " with another stamp)\n";
  }
  return kDone;
}

/// Bytes a second of each link, from two looks a second apart.
struct LinkLoad {
  std::string name;
  double baud = 0;
  double tx_bytes_s = 0;
  double rx_bytes_s = 0;
};

std::vector<LinkLoad> measure_loads(Session& session) {
  using Clock = std::chrono::steady_clock;
  const json before = session.call("link.list");
  const auto start = Clock::now();
  std::this_thread::sleep_for(std::chrono::seconds(1));
  const json after = session.call("link.list");
  const double seconds = std::chrono::duration<double>(Clock::now() - start).count();
  std::vector<LinkLoad> loads;
  for (const json& link : after) {
    for (const json& old : before) {
      if (old.at("name") != link.at("name")) continue;
      const auto rate = [&](const char* way) {
        return (link.at(way).at("bytes").get<double>() - old.at(way).at("bytes").get<double>()) /
               seconds;
      };
      loads.push_back({link.at("name"), link.value("baud", 0.0), rate("tx"), rate("rx")});
    }
  }
  return loads;
}

int show_budget(Session& session) {
  constexpr double kBitsPerByte = 10;  // start bit, eight data bits, stop bit
  constexpr double kFull = 90;         // percent from which bursts begin to queue
  Table table({"LINK", "BAUD", "CARRIES kB/s", "OUT kB/s", "OUT %", "IN kB/s", "IN %", "VERDICT"});
  json all = json::array();
  bool fits = true;
  for (const LinkLoad& load : measure_loads(session)) {
    const double capacity = load.baud / kBitsPerByte;
    const double out = capacity > 0 ? 100 * load.tx_bytes_s / capacity : 0;
    const double in = capacity > 0 ? 100 * load.rx_bytes_s / capacity : 0;
    const bool ok = out < kFull && in < kFull;
    fits = fits && ok;
    table.add({load.name, capacity > 0 ? fixed(load.baud, 0) : "-",
               capacity > 0 ? fixed(capacity / 1000, 1) : "-", fixed(load.tx_bytes_s / 1000, 1),
               capacity > 0 ? fixed(out, 0) : "-", fixed(load.rx_bytes_s / 1000, 1),
               capacity > 0 ? fixed(in, 0) : "-",
               capacity <= 0 ? "no limit" : (ok ? "carries it" : "TOO SLOW: raise the baud rate")});
    all.push_back({{"link", load.name},
                   {"baud", load.baud},
                   {"out_bytes_s", load.tx_bytes_s},
                   {"in_bytes_s", load.rx_bytes_s},
                   {"fits", ok}});
  }
  if (!printed_as_json(session.options(), all)) table.print(std::cout);
  return fits ? kDone : kRefused;
}

/// The sensors of each vehicle, beside its entry in casd.status.
void add_telemetry(Session& session, json& status) {
  for (json& vehicle : status.at("vehicles")) {
    try {
      json telemetry = session.call("vehicle.telemetry", {{"vehicle", vehicle.at("system")}});
      telemetry.erase("vehicle");
      vehicle["telemetry"] = std::move(telemetry);
    } catch (const base::rpc::CallError& error) {
      // The vehicle fell silent just now, or casd is older than this method.
      if (error.code() != base::rpc::kNoSuchVehicle && error.code() != base::rpc::kMethodNotFound) {
        throw;
      }
    }
  }
}

}  // namespace

void add_status_verbs(CommandLine& line) {
  line.add_verb("status", "Show links and vehicles", "casctl status --json", [](Session& session) {
    if (session.options().vehicle) session.vehicle_call("vehicle.state");  // or it is refused
    json status = session.call("casd.status");
    if (session.options().json) add_telemetry(session, status);
    if (!printed_as_json(session.options(), status)) print_status(status);
    return kDone;
  });
  line.add_verb("links", "Show each link's state and counters", "casctl links",
                [](Session& session) {
                  const json links = session.call("link.list");
                  if (!printed_as_json(session.options(), links)) {
                    print_links(links.is_object() ? links.value("links", json::array()) : links);
                  }
                  return kDone;
                });
}

void add_service_verbs(CommandLine& line) {
  line.add_verb("routes", "Show who hears whom", "casctl routes", show_routes);
  add_drops_verb(line);
  line.add_verb("latency", "Show forwarding times", "casctl latency", show_latency);
  line.add_verb("budget", "Measure whether the lines carry their load (1 s)", "casctl budget",
                show_budget);
  add_log_verb(line);
  line.add_verb(
      "reload", "Make casd read its topology again", "casctl reload", [](Session& session) {
        report(session.options(), session.call("casd.reload"), "the topology was read again");
        return kDone;
      });
  const auto not_hil = std::make_shared<bool>(false);
  line.add_verb("reboot", "Restart the flight controller", "casctl reboot --vehicle 1",
                [not_hil](Session& session) {
                  json params = json::object();
                  if (*not_hil) params["not_hil"] = true;
                  const json result = session.vehicle_call("vehicle.reboot", params);
                  report(session.options(), result,
                         "vehicle " + result.at("vehicle").dump() + " accepted the restart");
                  return kDone;
                })
      ->add_flag("--not-hil", *not_hil,
                 "Also an armed vehicle that does not say it is in HIL: IT FALLS; casd's "
                 "configuration must consent");
}

}  // namespace cas::casctl
