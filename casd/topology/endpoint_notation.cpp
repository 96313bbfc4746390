// SPDX-License-Identifier: BSD-3-Clause
#include "casd/topology/endpoint_notation.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <charconv>
#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <system_error>

#include "base/error.hpp"
#include "base/os/host_port.hpp"
#include "base/suggestion.hpp"
#include "base/text.hpp"
#include "casd/topology/endpoint_address.hpp"
#include "casd/topology/endpoint_conflict.hpp"

namespace cas::casd {
namespace {

enum class Direction : std::uint8_t { kByHost, kListen, kSend };

struct Scheme {
  std::string_view word;
  LinkType type;
  Direction direction;
};

constexpr std::string_view kMulticast = "mcast";
constexpr std::string_view kFlowControl = "serial_flowcontrol";  // MAVSDK's
constexpr unsigned kUsualPort = 14550;                           // of a ground station's UDP

constexpr std::array kSchemes{
    Scheme{"serial", LinkType::kSerial, Direction::kByHost},
    Scheme{kFlowControl, LinkType::kSerial, Direction::kByHost},
    Scheme{"udp", LinkType::kUdp, Direction::kByHost},
    Scheme{"udpin", LinkType::kUdp, Direction::kListen},
    Scheme{"udps", LinkType::kUdp, Direction::kListen},
    Scheme{"udpout", LinkType::kUdp, Direction::kSend},
    Scheme{"udpc", LinkType::kUdp, Direction::kSend},
    Scheme{"udpb", LinkType::kUdp, Direction::kSend},
    Scheme{"udpbcast", LinkType::kUdp, Direction::kSend},
    Scheme{"udpcast", LinkType::kUdp, Direction::kSend},
    Scheme{kMulticast, LinkType::kUdp, Direction::kSend},
    Scheme{"tcp", LinkType::kTcp, Direction::kByHost},
    Scheme{"tcpin", LinkType::kTcp, Direction::kListen},
    Scheme{"tcps", LinkType::kTcp, Direction::kListen},
    Scheme{"tcpout", LinkType::kTcp, Direction::kSend},
    Scheme{"tcpc", LinkType::kTcp, Direction::kSend},
};

[[noreturn]] void fail(const std::string& text, const std::string& sentence) {
  throw base::ConfigError("endpoint '" + text + "' " + sentence +
                          "; serial:/dev/ttyACM0:921600, udp:14550, udp:HOST:PORT, tcp:5760 and "
                          "tcp:HOST:PORT are endpoints");
}

const Scheme* scheme_of(std::string_view text) {
  const std::string_view word = text.substr(0, text.find(':'));
  if (word.size() == text.size()) return nullptr;
  const auto* found = std::find_if(kSchemes.begin(), kSchemes.end(),
                                   [&](const Scheme& scheme) { return scheme.word == word; });
  return found == kSchemes.end() ? nullptr : found;
}

std::optional<unsigned> number(std::string_view digits) {
  unsigned value = 0;
  const char* end = digits.data() + digits.size();
  const auto [stop, error] = std::from_chars(digits.data(), end, value);
  if (error != std::errc{} || stop != end) return std::nullopt;
  return value;
}

constexpr unsigned kLeastBaud = 300;

/// A slip in a rate would become part of the device's name.
void refuse_half_rate(const std::string& text, std::string_view device) {
  if (device.find(':') == device.npos || device.starts_with("/dev/serial/")) return;
  fail(text, "has no rate of 300 or more behind the colon; several: RATE,RATE");
}

/// Takes the rate off a DEVICE:BAUD. Names below /dev/serial have colons of their own; 0: USB.
void take_rate(const std::string& text, std::string_view& device, std::vector<unsigned>& rates) {
  const std::size_t colon = device.rfind(':');
  if (colon == device.npos) return;
  const std::optional<unsigned> rate = number(device.substr(colon + 1));
  if (rate && (device.ends_with(":0") || *rate >= kLeastBaud)) {
    if (*rate > 0) rates.push_back(*rate);
    device = device.substr(0, colon);
  }
  refuse_half_rate(text, device);
}

/// DEVICE, DEVICE:BAUD or DEVICE,BAUD, and further rates to try, each behind a comma.
LinkConfig serial_link(const std::string& text, std::string_view rest) {
  constexpr std::size_t kMostRates = 16;
  LinkConfig link;
  link.type = LinkType::kSerial;
  link.pass_unknown = true;  // as other routers do: a dialect of one's own
  std::string_view device = rest.substr(0, rest.find(','));
  take_rate(text, device, link.baud);
  for (std::size_t comma = rest.find(','); comma != rest.npos; comma = rest.find(',')) {
    rest.remove_prefix(comma + 1);
    const std::optional<unsigned> rate = number(rest.substr(0, rest.find(',')));
    if (!rate || *rate < kLeastBaud) fail(text, "has no rate after the comma");
    if (std::ranges::find(link.baud, *rate) != link.baud.end()) fail(text, "has a rate twice");
    link.baud.push_back(*rate);
  }
  if (link.baud.size() > kMostRates) fail(text, "has more than 16 rates");
  if (device.empty()) fail(text, "names no device");
  if (device.find('?') != device.npos) fail(text, "has a ?, which no device has");
  link.device = device;
  return link;
}

bool listens(const Scheme& scheme, const std::string& host, EndpointUse use) {
  if (scheme.direction != Direction::kByHost) return scheme.direction == Direction::kListen;
  if (host.empty() || EndpointAddress(host, 0).is_any()) return true;
  return scheme.type == LinkType::kUdp && use == EndpointUse::kMaster;
}

/// PORT, :PORT or HOST:PORT behind a scheme.
LinkConfig socket_link(const std::string& text, const Scheme& scheme, std::string_view rest,
                       EndpointUse use) {
  if (rest.find('@') != rest.npos) {
    fail(text,
         "has an @: instead of one URL of mavros write udpin:HOST:PORT, which listens, or "
         "udpout:HOST:PORT, which sends");
  }
  if (!rest.empty() && rest.front() == ':') rest.remove_prefix(1);
  std::string host;
  std::string port(rest);
  if (const auto parts = base::parse_host_port(rest)) {
    host = parts->host;
    port = parts->port;
  }
  if (host.find(':') != host.npos && (rest.front() != '[' || EndpointAddress(host, 0).is_name())) {
    fail(text, "has a host that is no IPv6 address in brackets, as [::1]:14550 is");
  }
  const std::optional<unsigned> value = number(port);
  if (!value) fail(text, "has no port");
  if (*value > 65535) fail(text, "has a port above 65535");
  const bool is_server = listens(scheme, host, use);
  if (host.empty() && !is_server) fail(text, "names no host to send to");
  if (!is_server && EndpointAddress(host, 0).is_any()) {
    fail(text, std::string(EndpointAddress::kNoDestination));
  }
  if (*value == 0 && !is_server) fail(text, "has port 0, to which nothing can be sent");
  const std::string v6_or_name = host.find(':') == host.npos ? host : "[" + host + "]";
  const std::string place = (host.empty() ? "127.0.0.1" : v6_or_name) + ":" + port;

  LinkConfig link;
  if (is_server) {
    link.type = scheme.type == LinkType::kUdp ? LinkType::kUdpServer : LinkType::kTcpServer;
    link.local = place;
  } else {
    link.type = scheme.type;
    link.remote = place;
  }
  return link;
}

/// HOST without a port, as mavlink-router's -e takes it.
bool is_bare_host(std::string_view text) {
  if (text.empty() || text.find('/') != text.npos) return false;
  if (text.front() == '[') return text.back() == ']';
  return text.find(':') == text.npos && !number(text);
}

/// Nothing, GROUP, :PORT or GROUP:PORT: sends to the group and receives from it.
LinkConfig multicast_link(const std::string& text, std::string_view rest) {
  std::string place(rest);
  if (rest.empty() || rest.front() == ':') place = "239.255.145.50" + place;  // MAVLink's group
  if (is_bare_host(place)) place += fmt::format(":{}", kUsualPort);
  LinkConfig link =
      socket_link(text, {kMulticast, LinkType::kUdp, Direction::kSend}, place, EndpointUse::kOut);
  if (!EndpointAddress(link.remote).is_multicast()) fail(text, "names no multicast group");
  const bool v6 = link.remote.starts_with('[');
  link.local = (v6 ? "[::]" : "0.0.0.0") + link.remote.substr(link.remote.rfind(':'));
  return link;
}

/// A host would be looked up under the name of a misspelt kind of endpoint.
void refuse_misspelt_scheme(const std::string& text) {
  std::array<std::string_view, kSchemes.size()> words;
  std::ranges::transform(kSchemes, words.begin(), &Scheme::word);
  const std::string begin = base::lower(text.substr(0, text.find(':')));
  if (text.starts_with("tty") && text.size() > 3 && (text[3] < 'a' || text[3] > 'z')) {
    fail(text, "is a device: /dev/" + text);
  }
  const std::string word = base::nearest_word(begin, words);
  if (!word.empty()) fail(text, "begins with no kind of endpoint: " + word + " is one");
}

/// udp, udp2, udp3: by type, servers and clients alike.
void name_links(std::vector<LinkConfig>& links) {
  std::map<std::string, int> count;
  for (LinkConfig& link : links) {
    if (!link.name.empty()) continue;
    std::string word(to_string(link.type));
    word = word.substr(0, word.find('_'));
    const int nth = ++count[word];
    link.name = nth == 1 ? word : fmt::format("{}{}", word, nth);
  }
}

std::string route_entry(const std::string& from, const std::string& to) {
  std::string text = "  - from: " + from + "\n    to: " + to + "\n    block: [";
  for (const std::string_view name : kSimulatorMessages) {
    text += (text.back() == '[' ? "" : ", ") + std::string(name);
  }
  return text + "]\n";
}

/// To everybody, also from one peer of a server to its others. Names are those of name_links().
std::string routes_of_endpoints(const std::vector<LinkConfig>& links) {
  std::string routes;
  if (links.size() > 1) routes += route_entry("any", "any");
  for (const LinkConfig& link : links) {
    if (is_server(link)) routes += route_entry(link.name, link.name);
  }
  if (routes.empty()) return "";
  return "routes:\n"
         "  # everything to everybody, but no sensor data of a simulator: "
         "a bench has a topology of its own\n" +
         routes;
}

}  // namespace

LinkConfig parse_endpoint(const std::string& text, EndpointUse use,
                          std::span<const LinkConfig> before) {
  std::string_view rest = text;
  const Scheme* scheme = scheme_of(text);
  if (scheme != nullptr) {
    rest.remove_prefix(scheme->word.size() + 1);
    if (rest.starts_with("//")) rest.remove_prefix(2);  // MAVSDK's URLs
    if (scheme->type == LinkType::kSerial) {
      LinkConfig link = serial_link(text, rest);
      link.flow_control = scheme->word == kFlowControl;
      return link;
    }
    if (scheme->word == kMulticast) return multicast_link(text, rest);
    return socket_link(text, *scheme, rest, use);
  }
  if (text.starts_with('/')) return serial_link(text, rest);
  if (use != EndpointUse::kOut) refuse_misspelt_scheme(text);
  const bool completed = use == EndpointUse::kOut && is_bare_host(text);
  const std::string place =
      completed ? fmt::format("{}:{}", text, next_udp_port(text, before)) : text;
  const Direction direction = use == EndpointUse::kOut ? Direction::kSend : Direction::kListen;
  return socket_link(text, {"udp", LinkType::kUdp, direction}, place, use);
}

unsigned next_udp_port(const std::string& host, std::span<const LinkConfig> before) {
  LinkConfig link;
  link.type = LinkType::kUdp;
  const auto is_taken = [&](unsigned port) {
    link.remote = fmt::format("{}:{}", host, port);
    return std::ranges::any_of(before,
                               [&](const LinkConfig& other) {
                                 return other.type == LinkType::kUdp && other.remote == link.remote;
                               }) ||
           endpoint_conflict(link, before);
  };
  unsigned port = kUsualPort;
  while (is_taken(port)) ++port;
  return port;
}

unsigned usual_baud(const std::string& device) {
  std::error_code none;
  const std::string real = std::filesystem::weakly_canonical(device, none).string();
  constexpr unsigned kRouters = 115'200;  // also of mavlink-router
  constexpr std::array<std::string_view, 8> kLines{"/dev/ttyS",   "/dev/ttyAMA", "/dev/ttyUSB",
                                                   "/dev/ttyTHS", "/dev/ttyHS",  "/dev/ttymxc",
                                                   "/dev/ttyO",   "/dev/serial"};
  const bool is_line = std::ranges::any_of(kLines, [&real](std::string_view begin) {
    return real.starts_with(begin) && number(std::string_view(real).substr(begin.size()));
  });
  return is_line ? kRouters : 0;
}

bool is_endpoint(std::string_view text) {
  if (text == "/dev/stdin" || text.starts_with("/dev/fd/")) return false;
  if (scheme_of(text) != nullptr || text.starts_with("/dev/")) return true;
  if (text.find("://") != text.npos) return true;
  const std::size_t colon = text.rfind(':');
  return colon != text.npos && number(text.substr(colon + 1)) && text.find('/') == text.npos;
}

std::string yaml_string(const std::string& text) {
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::string quoted = "\"";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte < ' ') {
      quoted += std::string("\\x") + kDigits[byte >> 4U] + kDigits[byte & 0xFU];
    } else {
      if (c == '"' || c == '\\') quoted += '\\';
      quoted += c;
    }
  }
  return quoted + '"';
}

std::string baud_text(const std::vector<unsigned>& rates) {
  const std::string list = fmt::format("{}", fmt::join(rates, ", "));
  return rates.size() == 1 ? list : "[" + list + "]";
}

std::string link_entry(const LinkConfig& link) {
  std::string entry =
      "- {name: " + yaml_string(link.name) + ", type: " + std::string(to_string(link.type));
  if (!link.local.empty()) entry += ", local: " + yaml_string(link.local);
  if (!link.remote.empty()) entry += ", remote: " + yaml_string(link.remote);
  if (!link.device.empty()) entry += ", device: " + yaml_string(link.device);
  if (link.type == LinkType::kSerial && link.pass_unknown) entry += ", unknown_messages: pass";
  if (!link.baud.empty()) entry += ", baud: " + baud_text(link.baud);
  if (link.flow_control) entry += ", flow_control: true";
  return entry + "}";
}

std::string topology_of_endpoints(std::vector<LinkConfig> links, const EndpointOptions& options) {
  name_links(links);
  std::string text = "schema: 1\n";
  if (options.command_port >= 0) {
    text += fmt::format("command_port: {{port: {}}}\n", options.command_port);
  }
  if (options.silent) text += "commanding: {heartbeat_hz: 0, ask_on_sight: false}\n";
  const EndpointLog& log = options.log;
  if (!log.folder.empty()) {
    text += "log:\n  folder: " + yaml_string(log.folder) + "\n";
    if (log.telemetry) text += "  tlog: flight\n";
    text += "  autopilot: {}\n";
  }
  text += "links:\n";
  for (const LinkConfig& link : links) text += "  " + link_entry(link) + "\n";
  return text + routes_of_endpoints(links);
}

}  // namespace cas::casd
