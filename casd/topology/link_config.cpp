// SPDX-License-Identifier: BSD-3-Clause
#include "casd/topology/link_config.hpp"

#include <array>

#include "base/config/config.hpp"
#include "base/config/config_whole.hpp"
#include "base/os/host_port.hpp"
#include "base/os/runtime_folder.hpp"
#include "mavlink_gen/parser/diagnostics.hpp"
#include "mavlink_gen/runtime/public_table.hpp"

namespace cas::casd {
namespace {

bool is_number(const std::string& text) {
  return !text.empty() && text.size() <= 8 &&
         text.find_first_not_of("0123456789") == std::string::npos;
}

[[noreturn]] void refuse_message(const base::ConfigNode& node, const std::string& text) {
  std::vector<std::string_view> names;
  for (const mav::MessageInfo& message : mav::public_table().all()) names.push_back(message.name);
  const std::string near = mav::xml::suggestion(text, names);
  node.fail("no public message has the name '" + text + "'" +
            (near.empty() ? "; give its number if it is private" : near));
}

constexpr std::array kTypes{LinkType::kUdp, LinkType::kUdpServer, LinkType::kSerial,
                            LinkType::kTcp, LinkType::kTcpServer, LinkType::kTlog};

LinkType parse_type(const base::ConfigNode& node) {
  const auto word = node.as<std::string>();
  for (const LinkType type : kTypes) {
    if (word == to_string(type)) return type;
  }
  node.fail("'" + word + "' is none of udp, udp_server, serial, tcp, tcp_server, tlog");
}

// "HOST:PORT" or "[V6]:PORT"; whether the host exists is found out when the link opens.
std::string parse_endpoint(const base::ConfigNode& node) {
  const auto text = node.as<std::string>();
  const std::optional<base::HostPort> parts = base::parse_host_port(text);
  if (!parts) node.fail("'" + text + "' is not HOST:PORT");
  const std::string& port = parts->port;
  const bool digits = port.size() <= 5 && port.find_first_not_of("0123456789") == port.npos;
  if (!digits || std::stoi(port) > 65535) node.fail("'" + port + "' is not a port");
  return text;
}

std::string optional_endpoint(const base::ConfigNode& node, std::string_view key) {
  const auto child = node.find(key);
  return child ? parse_endpoint(*child) : std::string();
}

void parse_udp(const base::ConfigNode& node, LinkConfig& link) {
  link.local = optional_endpoint(node, "local");
  link.remote = optional_endpoint(node, "remote");
  link.interface = node.get<std::string>("interface", "");
  if (link.local.empty() && link.remote.empty()) node.fail("needs local, remote or both");
}

void parse_server(const base::ConfigNode& node, LinkConfig& link) {
  link.local = parse_endpoint(node.at("local"));
  link.interface = node.get<std::string>("interface", "");
  link.max_peers = base::get_whole_in<int>(node, "max_peers", link.max_peers, 1, 64);
  if (link.type == LinkType::kUdpServer) {
    link.expiry =
        base::from_seconds(node.get_in("expiry_s", base::to_seconds(link.expiry), 0.1, 86400));
  }
}

void parse_tcp(const base::ConfigNode& node, LinkConfig& link) {
  link.remote = parse_endpoint(node.at("remote"));
  link.interface = node.get<std::string>("interface", "");
}

std::string parse_device(const base::ConfigNode& node) {
  const auto text = node.as<std::string>();
  try {
    return base::expand_variables(text);
  } catch (const base::ConfigError& error) {
    node.fail(error.what());
  }
}

void parse_serial(const base::ConfigNode& node, LinkConfig& link) {
  link.device = parse_device(node.at("device"));
  link.baud = base::get_whole_in<unsigned>(node, "baud", 0, 0, 12'000'000);
  link.flow_control = node.get<bool>("flow_control", false);
  link.pace = node.get<bool>("pace", link.baud > 0);
  link.pace_pty = link.pace && node.has("pace");
  if (link.pace && link.baud == 0) node.at("pace").fail("a line without baud has no pace");
  link.unlocked_pty = node.get<bool>("unlocked_pty", false);
  constexpr double kLongestGap_ms = 20;
  link.sensor_gap = base::from_seconds(1e-3 * node.get_in("sensor_gap_ms", 0, 0, kLongestGap_ms));
}

void parse_tlog(const base::ConfigNode& node, LinkConfig& link) {
  link.file = node.resolve(node.require<std::string>("file"));
  link.speed = node.get_in("speed", link.speed, 0.01, 1000);
  link.repeat = node.get<bool>("repeat", false);
}

void parse_queue(const base::ConfigNode& node, TxQueueOptions& queue) {
  const auto ms = [&](std::string_view key, base::Duration fallback) {
    return base::from_seconds(node.get_in(key, base::to_seconds(fallback) * 1e3, 0.1, 60'000) /
                              1e3);
  };
  const auto kib = [&](std::string_view key, std::size_t fallback) {
    const auto low = 1.0;
    return static_cast<std::size_t>(
        node.get_in(key, static_cast<double>(fallback) / 1024, low, 65536) * 1024);
  };
  queue.hil_max_age = ms("hil_max_age_ms", queue.hil_max_age);
  queue.gps_max_age = ms("gps_max_age_ms", queue.gps_max_age);
  queue.setpoint_max_age = ms("setpoint_max_age_ms", queue.setpoint_max_age);
  queue.telemetry_max_age = ms("telemetry_max_age_ms", queue.telemetry_max_age);
  queue.command_bytes = kib("command_kib", queue.command_bytes);
  queue.hil_bytes = kib("hil_kib", queue.hil_bytes);
  queue.gps_bytes = kib("gps_kib", queue.gps_bytes);
  queue.telemetry_bytes = kib("telemetry_kib", queue.telemetry_bytes);
}

AcceptRule parse_accept(const base::ConfigNode& node) {
  AcceptRule rule;
  if (!node.is_map()) {
    const auto word = node.as<std::string>();
    if (word != "nothing") {
      node.fail("'" + word +
                "' is neither nothing nor {traffic, messages, systems, block_systems}");
    }
    rule.read_only = true;
    return rule;
  }
  if (const auto traffic = node.find("traffic")) {
    const auto word = traffic->as<std::string>();
    if (word != "ground_station") traffic->fail("'" + word + "' is not ground_station");
    rule.ground_station = true;
  }
  if (const auto messages = node.find("messages")) rule.messages = parse_messages(*messages);
  rule.systems = parse_bytes(node, "systems");
  rule.block_systems = parse_bytes(node, "block_systems");
  if (rule == AcceptRule{}) node.fail("names neither traffic, messages, systems nor block_systems");
  return rule;
}

constexpr double kLongestFuture_s = 50 * 365 * 86400.0;

SigningConfig parse_signing(const base::ConfigNode& node) {
  SigningConfig signing;
  signing.key_file = node.resolve(node.require<std::string>("key_file"));
  signing.link_id = base::get_whole_in<std::uint8_t>(node, "link_id", 0, 0, 255);
  signing.verify = node.get<bool>("verify", true);
  signing.sign = node.get<bool>("sign", true);
  if (const auto list = node.find("allow_unsigned")) {
    if (!signing.verify) list->fail("has no meaning without verify");
    signing.allow_unsigned = parse_messages(*list);
  }
  if (const auto bound = node.find("max_future_s"); bound && !signing.verify) {
    bound->fail("has no meaning without verify");
  }
  signing.max_future = base::from_seconds(
      node.get_in("max_future_s", base::to_seconds(signing.max_future), 0, kLongestFuture_s));
  if (!signing.verify && !signing.sign) node.fail("neither verifies nor signs");
  return signing;
}

void parse_common(const base::ConfigNode& node, LinkConfig& link) {
  link.max_bytes_s = node.get_in("max_bytes_s", 0, 0, 1e12);
  link.pass_unknown = link.type != LinkType::kSerial;  // a socket has a checksum of its own
  if (const auto unknown = node.find("unknown_messages")) {
    const auto word = unknown->as<std::string>();
    if (word != "pass" && word != "drop") unknown->fail("'" + word + "' is neither pass nor drop");
    link.pass_unknown = word == "pass";
  }
  link.group = node.get<std::string>("group", "");
  if (const auto accept = node.find("accept")) link.accept = parse_accept(*accept);
  if (const auto signing = node.find("signing")) link.signing = parse_signing(*signing);
  if (const auto queue = node.find("queue")) parse_queue(*queue, link.queue);
  if (const auto scheduling = node.find("scheduling")) {
    link.scheduling = base::parse_thread_options(*scheduling);
  }
}

}  // namespace

std::vector<base::ConfigNode> one_or_many(const base::ConfigNode& node) {
  return node.is_list() ? node.items() : std::vector{node};
}

// Numbers may be of dialects that we do not know.
std::uint32_t parse_message(const base::ConfigNode& node, const std::string& text) {
  if (is_number(text)) {
    const unsigned long id = std::stoul(text);
    if (id > 0xFFFFFF) node.fail(text + " is beyond the message ids (24 bits)");
    return static_cast<std::uint32_t>(id);
  }
  const mav::MessageInfo* known = mav::public_table().find(text);
  if (known == nullptr) refuse_message(node, text);
  return known->id;
}

std::vector<std::uint32_t> parse_messages(const base::ConfigNode& node) {
  std::vector<std::uint32_t> ids;
  for (const base::ConfigNode& entry : one_or_many(node)) {
    ids.push_back(parse_message(entry, entry.as<std::string>()));
  }
  return ids;
}

std::vector<std::uint8_t> parse_bytes(const base::ConfigNode& node, std::string_view key) {
  std::vector<std::uint8_t> ids;
  const auto list = node.find(key);
  if (!list) return ids;
  for (const base::ConfigNode& entry : one_or_many(*list)) {
    const int id = entry.as<int>();
    if (id < 0 || id > 255) entry.fail(std::to_string(id) + " is not an id (0..255)");
    ids.push_back(static_cast<std::uint8_t>(id));
  }
  return ids;
}

LinkConfig parse_link(const base::ConfigNode& node) {
  LinkConfig link;
  link.name = node.require<std::string>("name");
  if (link.name.empty() || link.name == "any")
    node.at("name").fail("a link needs a name of its own");
  link.type = parse_type(node.at("type"));
  switch (link.type) {
    case LinkType::kUdp:
      parse_udp(node, link);
      break;
    case LinkType::kUdpServer:
    case LinkType::kTcpServer:
      parse_server(node, link);
      break;
    case LinkType::kTcp:
      parse_tcp(node, link);
      break;
    case LinkType::kSerial:
      parse_serial(node, link);
      break;
    case LinkType::kTlog:
      parse_tlog(node, link);
      break;
  }
  parse_common(node, link);
  node.reject_unused();
  return link;
}

}  // namespace cas::casd
