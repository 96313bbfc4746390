// SPDX-License-Identifier: BSD-3-Clause
#include "casd/topology/topology_text.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "base/config/key_table.hpp"
#include "base/text.hpp"
#include "casd/topology/injection.hpp"
#include "casd/topology/line_budget.hpp"
#include "casd/topology/message_keys.hpp"
#include "casd/topology/topology.hpp"

namespace cas::casd {
namespace {

/// ", refuses systems 1 2" for a list that is not empty. @tparam Kind  of its key
template <class Kind, class List>
std::string listed(std::string_view what, const List& list) {
  return list.empty() ? "" : ", " + std::string(what) + " " + Kind::text(list);
}

std::string where(const LinkConfig& link) {
  std::string text;
  if (!link.local.empty()) text += " at " + link.local;
  if (!link.remote.empty()) text += " to " + link.remote;
  if (!link.device.empty()) text += " " + link.device;
  if (!link.baud.empty()) {
    text += " at " + words_of_rates(link.baud) + " baud" + (link.pace ? ", paced" : ", not paced");
  }
  if (!link.file.empty()) text += " " + link.file.string();
  return text;
}

/// "    queue.hil_max_age_ms 20, max_bytes_s 1000"; or nothing.
/// @param told  keys that the text before has; "accept.": all of that block
std::string keys_line(std::vector<std::string> changed, std::span<const std::string_view> told) {
  std::erase_if(changed, [told](const std::string& entry) {
    const std::string_view key = std::string_view(entry).substr(0, entry.find(' '));
    return std::ranges::any_of(told, [key](std::string_view each) {
      return each.ends_with('.') ? key.starts_with(each) : key == each;
    });
  });
  return changed.empty() ? "" : "    " + base::joined(changed, ", ") + "\n";
}

std::string link_line(const LinkConfig& link, Pace pace) {
  std::string text = "  " + link.name + ": " + std::string(to_string(link.type)) + where(link);
  if (!link.group.empty()) text += ", group " + link.group;
  if (link.unlocked_pty) text += ", asks no lock of a pseudo-terminal";
  if (link.sniffer) {
    text += ", sniffer: gets every packet, takes in nothing";
  } else if (link.accept.read_only) {
    text += ", read-only";
  }
  if (link.accept.ground_station) text += ", accepts what ground stations say";
  text +=
      listed<Messages>(link.accept.ground_station ? "and" : "accepts only", link.accept.messages);
  text += listed<Ids>("accepts only systems", link.accept.systems);
  text += listed<Ids>("refuses systems", link.accept.block_systems);
  if (may_inject_failures(link)) text += ", may inject failures";
  if (link.signing) {
    text += std::string(link.signing->verify ? ", verifies" : "") +
            (link.signing->sign ? ", signs" : "") + " with " + link.signing->key_file.string();
  }
  constexpr std::array<std::string_view, 19> kTold{
      "local", "remote", "device", "baud", "pace", "file", "to_not_hil", "sniffer", "accept.",
      "inject_failures", "group", "unlocked_pty", "signing.key_file", "signing.verify",
      "signing.sign",
      // set by lockstep
      "queue.hil_max_age_ms", "queue.gps_max_age_ms", "queue.setpoint_max_age_ms",
      "queue.telemetry_max_age_ms"};
  const std::size_t told = pace == Pace::kLockstep ? kTold.size() : kTold.size() - 4;
  return text + "\n" + keys_line(changed_keys(link), std::span(kTold).first(told));
}

/// "to vehicles not in HIL\n  all: sim, fcu\n  stops only: replay\n": the rule of each link.
std::string interlock_text(const Topology& topology) {
  const auto names = [&topology](ToNotHil rule) {
    std::vector<std::string> links;
    for (const LinkConfig& link : topology.links) {
      if (!link.accept.read_only && link.to_not_hil == rule) links.push_back(link.name);
    }
    return base::joined(links, ", ");
  };
  const std::string all = names(ToNotHil::kAll);
  const std::string stops_only = names(ToNotHil::kStopsOnly);
  std::string text = "to vehicles not in HIL\n";
  if (!all.empty()) text += "  all: " + all + "\n";
  if (!stops_only.empty()) text += "  stops only: " + stops_only + "\n";
  return text;
}

std::string command_port_text(const CommandPortConfig& port) {
  std::string text = fmt::format("{}:{}", port.address, port.port);
  text += port.loopback_without_token ? " (no token from this machine)" : " (with a token)";
  if (port.unix_path && !port.unix_path->empty()) text += ", unix " + port.unix_path->string();
  return text;
}

}  // namespace

std::string topology_text(const Topology& topology) {
  std::string text = fmt::format(
      "system {}/{}, threads {}, command port {}\n", topology.self.system, topology.self.component,
      to_string(topology.threads), command_port_text(topology.command_port));
  constexpr std::array<std::string_view, 7> kTold{"system_id",
                                                  "component_id",
                                                  "threads",
                                                  "command_port.address",
                                                  "command_port.port",
                                                  "command_port.unix",
                                                  "command_port.loopback_without_token"};
  text += keys_line(changed_keys(topology), kTold) + "links\n";
  for (const LinkConfig& link : topology.links) text += link_line(link, topology.pace);
  text += interlock_text(topology) + "routes\n";
  for (const RouteConfig& route : topology.routes) {
    text += "  " + route.from + " -> " + route.to + ": " + rule_text(route.rule) + "\n";
  }
  const std::vector<LineBudget> budgets = line_budgets(topology);
  if (!budgets.empty()) text += "expected load of the lines\n";
  return text + describe(budgets);
}

namespace {

/// The lines of links' keys, each once with all types that have it alike.
std::string lines_by_type() {
  std::vector<std::pair<std::string, std::string>> lines;  // types of a line, and it
  for (int i = 0; i <= static_cast<int>(LinkType::kTlog); ++i) {
    const auto type = static_cast<LinkType>(i);
    for (const base::KeyRow& row : link_rows(type)) {
      const std::string line = base::key_lines({row}, " | ");
      auto found = std::ranges::find(lines, line, &std::pair<std::string, std::string>::second);
      if (found == lines.end()) found = lines.insert(found, {"", line});
      found->first += (found->first.empty() ? "`" : ", `") + std::string(to_string(type)) + "`";
    }
  }
  std::string text;
  for (const auto& [types, line] : lines) text += line.substr(0, 2) + types + line.substr(2);
  return text;
}

}  // namespace

std::string topology_reference() {
  constexpr std::string_view kHead = "default | values | meaning |\n";
  std::string text;
  text.append("| a reload | key | ").append(kHead).append("|---|---|---|---|---|\n");
  text += base::key_lines(restart_rows(), "restart | ");
  text += base::key_lines(reload_rows(), "in force | ");

  text.append("\nOne of `links`:\n\n| type | key | ")
      .append(kHead)
      .append("|---|---|---|---|---|\n");
  text += base::key_lines(link_rows({}), "all | ");
  text += lines_by_type();

  text.append("\nOne of `routes`:\n\n| key | ").append(kHead).append("|---|---|---|---|\n");
  text += base::key_lines(route_rows());
  return text;
}

}  // namespace cas::casd
