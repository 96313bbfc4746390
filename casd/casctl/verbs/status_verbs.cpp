// SPDX-License-Identifier: BSD-3-Clause
#include <iostream>

#include "casd/casctl/session/table.hpp"
#include "casd/casctl/verbs/verbs.hpp"

namespace cas::casctl {
namespace {

using nlohmann::json;

std::string count(const json& object, const char* key) {
  const auto found = object.find(key);
  return found == object.end() || !found->is_number() ? "-" : found->dump();
}

std::uint64_t sum(const json& causes) {
  std::uint64_t total = 0;
  if (!causes.is_object()) return 0;
  for (const auto& item : causes.items()) {
    if (item.value().is_number_unsigned()) total += item.value().get<std::uint64_t>();
  }
  return total;
}

void print_links(const json& links) {
  Table table({"LINK", "TYPE", "STATE", "ENDPOINT", "RX", "LOST", "CRC", "TX", "DROPPED", "QUEUE",
               "RECONNECTS"});
  for (const json& link : links) {
    const json rx = link.value("rx", json::object());
    const json tx = link.value("tx", json::object());
    table.add({link.value("name", "?"), link.value("type", "?"), link.value("state", "?"),
               link.value("endpoint", ""), count(rx, "packets"), count(rx, "lost"),
               count(rx, "crc_errors"), count(tx, "packets"),
               std::to_string(sum(tx.value("dropped", json::object()))),
               count(tx, "queue_high_water"), count(link, "reconnects")});
  }
  table.print(std::cout);
}

void print_vehicles(const json& vehicles) {
  Table table(
      {"VEHICLE", "AUTOPILOT", "TYPE", "ARMED", "HIL", "MODE", "LANDED", "LINK", "HEARTBEAT"});
  for (const json& vehicle : vehicles) {
    table.add({count(vehicle, "system"), vehicle.value("autopilot", "?"),
               vehicle.value("type", "?"), vehicle.value("armed", false) ? "armed" : "no",
               vehicle.value("hil", false) ? "yes" : "NO", vehicle.value("mode", "?"),
               vehicle.value("landed", "?"), vehicle.value("link", "?"),
               duration_text(vehicle.value("heartbeat_age_s", 0.0)) + " ago"});
  }
  if (table.empty()) {
    std::cout << "no vehicle heard yet: is its link up, and does it send HEARTBEAT?\n";
  } else {
    table.print(std::cout);
  }
  for (const json& vehicle : vehicles) {
    for (const json& complaint : vehicle.value("complaints", json::array())) {
      std::cout << "vehicle " << count(vehicle, "system") << ": " << complaint.get<std::string>()
                << '\n';
    }
  }
}

void print_status(const json& status) {
  std::cout << "casd " << status.value("version", "?") << ", up "
            << duration_text(status.value("uptime_s", 0.0)) << ", threads "
            << status.value("threads", "?") << "\n\n";
  print_links(status.value("links", json::array()));
  std::cout << '\n';
  print_vehicles(status.value("vehicles", json::array()));
}

}  // namespace

void add_status_verbs(CommandLine& line) {
  line.add_verb("status", "Show links and vehicles", "casctl status --json", [](Session& session) {
    if (session.options().vehicle) session.vehicle_call("vehicle.state");  // or it is refused
    const json status = session.call("casd.status");
    if (session.options().json) {
      report(session.options(), status, "");
    } else {
      print_status(status);
    }
    return kDone;
  });
  line.add_verb("links", "Show each link's state and counters", "casctl links",
                [](Session& session) {
                  const json links = session.call("link.list");
                  if (session.options().json) {
                    report(session.options(), links, "");
                  } else {
                    print_links(links.is_object() ? links.value("links", json::array()) : links);
                  }
                  return kDone;
                });
}

}  // namespace cas::casctl
