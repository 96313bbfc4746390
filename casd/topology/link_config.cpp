// SPDX-License-Identifier: BSD-3-Clause
#include "casd/topology/link_config.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <cstddef>
#include <tuple>

#include "base/config/changed_keys.hpp"
#include "base/config/config_keys.hpp"
#include "base/config/removed_keys.hpp"
#include "base/os/host_port.hpp"
#include "base/os/runtime_folder.hpp"
#include "base/os/thread_keys.hpp"
#include "casd/topology/endpoint_address.hpp"
#include "casd/topology/link_name.hpp"
#include "casd/topology/message_keys.hpp"

namespace cas::casd {
namespace {

using base::block;
using base::ConfigNode;
using base::Flag;
using base::key;
using base::PathBeside;
using base::Range;
using base::required;
using base::Text;
using base::Whole;
using base::Words;

// Kinds that links alone have.

struct LinkName : Text {
  static void read(const ConfigNode& node, std::string& name) {
    Text::read(node, name);
    if (name.empty() || name == "any") node.fail("a link needs a name of its own");
    if (!is_link_name(name)) node.fail("a link's name has up to 64 letters, digits, and _ - .");
  }
};

/// "HOST:PORT" or "[V6]:PORT"; whether the host exists is found out when the link opens.
struct Endpoint : Text {
  static void read(const ConfigNode& node, std::string& endpoint) {
    Text::read(node, endpoint);
    const std::optional<base::HostPort> parts = base::parse_host_port(endpoint);
    if (!parts) node.fail("'" + endpoint + "' is not HOST:PORT");
    if (!base::is_host_text(parts->host)) node.fail("'" + parts->host + "' is not a host");
    if (!base::parse_port(parts->port)) node.fail("'" + parts->port + "' is not a port");
  }
  static std::string values() { return "HOST:PORT"; }
  static std::array<std::string, 2> samples() { return {"'127.0.0.1:0'", "'127.0.0.2:0'"}; }
};

/// Where a link sends.
struct Destination : Endpoint {
  static void read(const ConfigNode& node, std::string& endpoint) {
    Endpoint::read(node, endpoint);
    if (!EndpointAddress(endpoint).is_any()) return;
    node.fail(endpoint + " " + std::string(EndpointAddress::kNoDestination));
  }
};

struct Device : Text {
  static void read(const ConfigNode& node, std::string& device) {
    Text::read(node, device);
    try {
      device = base::expand_variables(device);
    } catch (const base::ConfigError& error) {
      node.fail(error.what());
    }
  }
};

/// A rate, or several that are tried in turn.
struct BaudRates {
  static constexpr int kHighest = 12'000'000;
  static constexpr std::size_t kMost = 16;

  static void read(const ConfigNode& node, std::vector<unsigned>& rates) {
    rates.clear();
    if (!node.is_list()) {
      const auto rate = static_cast<unsigned>(base::whole_in(node, 0, kHighest));
      if (rate > 0) rates.push_back(rate);
      return;
    }
    for (const ConfigNode& each : node.items()) {
      const auto rate = static_cast<unsigned>(base::whole_in(each, 1, kHighest));
      if (std::find(rates.begin(), rates.end(), rate) != rates.end()) {
        each.fail(fmt::format("{} is in the list already", rate));
      }
      rates.push_back(rate);
    }
    if (rates.empty()) node.fail("is an empty list");
    if (rates.size() > kMost) node.fail(fmt::format("has more than {} rates", kMost));
  }
  static std::string text(const std::vector<unsigned>& rates) {
    return rates.empty() ? "0" : words_of_rates(rates);
  }
  static std::string values() { return "0 to 12000000, or a list"; }
  static std::array<std::string, 2> samples() { return {"57600", "[57600, 921600]"}; }
};

template <LinkType... types>
constexpr auto type_words() {
  return Words<LinkType, sizeof...(types)>{{{{to_string(types), types}...}}};
}

// `signing`

constexpr double kLongestFuture_s = 50 * 365 * 86400.0;

constexpr std::tuple kSigningKeys{
    required(key<&SigningConfig::key_file>(
        "key_file", PathBeside{},
        "its first line: 64 hexadecimal digits are the key, anything else of 16 characters or "
        "more is a pass phrase (SHA-256, as ground stations do it)")),
    key<&SigningConfig::link_id>("link_id", Whole{0, 255},
                                 "in each signature: tells links of one key apart"),
    key<&SigningConfig::verify>("verify", Flag{}, "false: only sign"),
    key<&SigningConfig::sign>("sign", Flag{}, "false: only verify"),
    key<&SigningConfig::allow_unsigned>(
        "allow_unsigned", Messages{},
        "messages that may come unsigned, RADIO_STATUS of a modem for example"),
    key<&SigningConfig::max_future>(
        "max_future_s", Range{0, kLongestFuture_s},
        "how far a signed packet may be ahead of casd's clock; further ahead it is refused and "
        "counted as `too_new`. 0: any, as MAVLink has it"),
};

void check_signing(const ConfigNode& node, const SigningConfig& signing) {
  if (signing.verify) return;
  for (const char* of_verifying : {"allow_unsigned", "max_future_s"}) {
    if (const auto child = node.find(of_verifying)) child->fail("has no meaning without verify");
  }
  if (!signing.sign) node.fail("neither verifies nor signs");
}

// `queue`

constexpr Range kAge_ms{0.1, 60'000, 1e-3};

constexpr std::tuple kQueueKeys{
    key<&TxQueueOptions::hil_max_age>("hil_max_age_ms", kAge_ms, "how long HIL packets wait"),
    key<&TxQueueOptions::gps_max_age>("gps_max_age_ms", kAge_ms, "how long HIL_GPS waits"),
    key<&TxQueueOptions::setpoint_max_age>(
        "setpoint_max_age_ms", kAge_ms,
        "how long setpoints wait; 500 ms is the time after which PX4 takes sticks for lost"),
    key<&TxQueueOptions::telemetry_max_age>("telemetry_max_age_ms", kAge_ms,
                                            "how long telemetry waits"),
};

void refuse_memory(const ConfigNode& node, const TxQueueOptions& /*queue*/) {
  constexpr const char* kNow = "each class of packets has memory of a fixed size";
  base::refuse_removed(
      node, {{"command_kib", kNow}, {"hil_kib", kNow}, {"gps_kib", kNow}, {"telemetry_kib", kNow}});
}

// `accept`

constexpr std::tuple kAcceptKeys{
    key<&AcceptRule::ground_station>(
        "traffic", Words<bool, 1>{{{{"ground_station", true}}}, "'{}' is not ground_station"},
        "what ground stations say, and the `messages` that are named besides"),
    key<&AcceptRule::messages>("messages", Messages{}, "these messages alone"),
    key<&AcceptRule::systems>("systems", Ids{}, "these senders (system ids) alone"),
    key<&AcceptRule::block_systems>("block_systems", Ids{}, "not these senders"),
};

/// `everything`, `nothing`, or a block.
struct Accept : base::Block<AcceptRule, decltype(kAcceptKeys)> {
  void read(const ConfigNode& node, AcceptRule& rule) const {
    if (node.is_map()) {
      Block::read(node, rule);
      if (rule == AcceptRule{}) {
        node.fail("names neither traffic, messages, systems nor block_systems");
      }
      return;
    }
    const auto word = node.as<std::string>();
    if (word != "nothing" && word != "everything") {
      node.fail("'" + word +
                "' is neither everything, nothing nor {traffic, messages, systems, "
                "block_systems}");
    }
    rule.read_only = word == "nothing";
  }
  static std::string text(const AcceptRule& /*all*/) { return "everything"; }
  static std::string values() { return "everything, nothing, or a block"; }
  static std::array<std::string, 2> samples() { return {"nothing", "{systems: [1]}"}; }
};

// `request_rates`

/// message -> rate in Hz.
struct RequestRates {
  /// A vehicle's commands wait in line, and others need room there.
  static constexpr std::size_t kMost = 40;
  static constexpr Range kHz{0, 1000};

  static void read(const ConfigNode& node, std::vector<MessageRate>& rates) {
    for (const auto& [message, entry] : node.entries()) {
      kHz.read(entry, rates.emplace_back(MessageRate{parse_message(entry, message), 0}).hz);
    }
    if (rates.size() > kMost) node.fail("asks for more than 40 messages");
  }
  static std::string text(const std::vector<MessageRate>& rates) {
    return joined(rates, [](const MessageRate& rate) {
      return message_word(rate.message_id) + " " + base::number_text(rate.hz);
    });
  }
  static std::string values() { return "message -> Hz, 0 to 1000"; }
  static std::array<std::string, 2> samples() { return {"{ATTITUDE: 50}", "{ATTITUDE: 0}"}; }
};

// Links by type.

constexpr std::tuple kHeadKeys{
    required(key<&LinkConfig::name>(
        "name", LinkName{}, "one of its own, not `any`: up to 64 letters, digits, `_ - .`")),
    required(
        key<&LinkConfig::type>("type",
                               type_words<LinkType::kUdp, LinkType::kUdpServer, LinkType::kSerial,
                                          LinkType::kTcp, LinkType::kTcpServer, LinkType::kTlog>(),
                               "its other keys follow from it")),
};

constexpr auto kLocal = key<&LinkConfig::local>("local", Endpoint{}, "where it is bound");
constexpr auto kRemote = key<&LinkConfig::remote>(
    "remote", Destination{}, "its peer; of UDP also a broadcast or multicast address");
constexpr auto kInterface =
    key<&LinkConfig::interface>("interface", Text{}, "network device that it is bound to", "any");
constexpr auto kMaxPeers =
    key<&LinkConfig::max_peers>("max_peers", Whole{1, 64}, "peers at one time");

constexpr auto kSniffer = key<&LinkConfig::sniffer>(
    "sniffer", Flag{},
    "gets every packet, whatever its target and the routes, and takes in nothing; see below");

constexpr std::tuple kUdpKeys{kLocal, kRemote, kInterface, kSniffer};
constexpr std::tuple kTcpKeys{required(kRemote), kInterface, kSniffer};
constexpr std::tuple kTcpServerKeys{required(kLocal), kInterface, kMaxPeers, kSniffer};
constexpr std::tuple kUdpServerKeys{
    required(kLocal), kInterface, kMaxPeers,
    key<&LinkConfig::expiry>("expiry_s", Range{0.1, 86400},
                             "silence that ends a peer; of one that brings HIGH_LATENCY2 not "
                             "before 200 s"),
    kSniffer};

constexpr std::tuple kSerialKeys{
    required(key<&LinkConfig::device>("device", Device{},
                                      "its path, in which `${NAME}` is a variable of the "
                                      "environment; see [below](#pseudo-terminals)")),
    key<&LinkConfig::baud>("baud", BaudRates{},
                           "0: USB, which has no rate of its own; of a list the rate at which "
                           "packets come, see below"),
    key<&LinkConfig::flow_control>("flow_control", Flag{}, "RTS/CTS"),
    key<&LinkConfig::pace>("pace", Flag{}, "no more is written than 98 % of `baud`; see below",
                           "true where there is a `baud`"),
    key<&LinkConfig::unlocked_pty>(
        "unlocked_pty", Flag{},
        "also takes a pseudo-terminal without a lock; see [below](#pseudo-terminals)"),
    key<&LinkConfig::sensor_gap>("sensor_gap_ms", Range{0, 20, 1e-3},
                                 "least time between two HIL_SENSOR, for controllers that stamp "
                                 "them on arrival"),
};

constexpr std::tuple kTlogKeys{
    required(key<&LinkConfig::file>("file", PathBeside{},
                                    "a telemetry log, played as if its packets came in now; "
                                    "nothing is sent to it")),
    key<&LinkConfig::speed>("speed", Range{0.01, 1000}, "recorded seconds per second"),
    key<&LinkConfig::repeat>("repeat", Flag{}, "from the start again at its end"),
    key<&LinkConfig::commands>("commands", Flag{},
                               "plays what ground stations said, too: commands, sticks, "
                               "parameters; false: what vehicles said"),
};

constexpr std::tuple kCommonKeys{
    key<&LinkConfig::max_bytes_s>("max_bytes_s", Range{0, 1e12}, "cap on what is sent; 0: none"),
    key<&LinkConfig::pass_unknown>(
        "unknown_messages",
        Words<bool, 2>{{{{"pass", true}, {"drop", false}}}, "'{}' is neither pass nor drop"},
        "messages that no public dialect has", "pass, on serial lines drop"),
    key<&LinkConfig::to_not_hil>(
        "to_not_hil",
        Words<ToNotHil, 2>{{{{"all", ToNotHil::kAll}, {"stops_only", ToNotHil::kStopsOnly}}},
                           "'{}' is neither all nor stops_only"},
        "what passes from here to vehicles that do not say that they are in HIL; see below",
        "all, of tlog stops_only"),
    key<&LinkConfig::group>("group", Text{}, "redundant paths share the name of a group"),
    key<&LinkConfig::accept>("accept", Accept{{kAcceptKeys}},
                             "what the link takes in at all; see below"),
    key<&LinkConfig::inject_failures>(
        "inject_failures", Flag{},
        "stations here may have failures strike in the simulator "
        "([MAV_CMD_INJECT_FAILURE](../use/campaign.md#failures-injected-by-a-ground-station))"),
    key<&LinkConfig::request_rates>(
        "request_rates", RequestRates{},
        "what casd asks vehicles that it hears here for, by MAV_CMD_SET_MESSAGE_INTERVAL; 0: not "
        "at all; see below"),
    key<&LinkConfig::signing>("signing", block<SigningConfig>(kSigningKeys, check_signing),
                              "MAVLink 2 signing of this link; see below"),
    key<&LinkConfig::queue>("queue", block<TxQueueOptions>(kQueueKeys, refuse_memory),
                            "how long packets are worth sending; see below"),
    key<&LinkConfig::scheduling>("scheduling", block<base::ThreadOptions>(base::kThreadKeys),
                                 "of the link's thread, instead of the topology's; with `threads: "
                                 "auto` the link gets a thread of its own; without effect with "
                                 "`single` and `blocking`"),
};

/// Calls visit(keys) with those that links of a type have besides the common ones.
template <class Visit>
void with_keys_of(LinkType type, Visit&& visit) {
  switch (type) {
    case LinkType::kUdp:
      return visit(kUdpKeys);
    case LinkType::kUdpServer:
      return visit(kUdpServerKeys);
    case LinkType::kSerial:
      return visit(kSerialKeys);
    case LinkType::kTcp:
      return visit(kTcpKeys);
    case LinkType::kTcpServer:
      return visit(kTcpServerKeys);
    case LinkType::kTlog:
      return visit(kTlogKeys);
  }
}

void set_defaults_of_type(LinkConfig& link) {
  link.pass_unknown = link.type != LinkType::kSerial;  // a socket has a checksum of its own
  // A log is a recording: nobody looks at the vehicle that it would fly.
  link.to_not_hil = link.type == LinkType::kTlog ? ToNotHil::kStopsOnly : ToNotHil::kAll;
}

// A pace that is left out follows from the baud rate, and does not hold a pseudo-terminal.
void settle_pace(const ConfigNode& node, LinkConfig& link) {
  const auto given = node.find("pace");
  if (!given) link.pace = !link.baud.empty();
  link.pace_pty = given && link.pace;
  if (link.pace && link.baud.empty()) given->fail("a line without baud has no pace");
}

// What a sniffer sends would be taken for a vehicle's or a station's.
void settle_sniffer(const ConfigNode& node, LinkConfig& link) {
  for (const char* of_senders : {"accept", "group", "inject_failures"}) {
    if (const auto child = node.find(of_senders)) {
      child->fail("has no meaning for a sniffer, of which nothing is taken in");
    }
  }
  link.accept.read_only = true;
}

}  // namespace

const LinkConfig* find_link(const std::vector<LinkConfig>& links, std::string_view name) {
  const auto found = std::ranges::find(links, name, &LinkConfig::name);
  return found == links.end() ? nullptr : &*found;
}

unsigned lowest_baud(const LinkConfig& link) {
  return link.baud.empty() ? 0 : *std::min_element(link.baud.begin(), link.baud.end());
}

std::string words_of_rates(const std::vector<unsigned>& baud) {
  return fmt::format("{}", fmt::join(baud, " or "));
}

LinkConfig parse_link(const ConfigNode& node) {
  LinkConfig link;
  base::read_keys(node, kHeadKeys, link);
  set_defaults_of_type(link);
  with_keys_of(link.type, [&](const auto& keys) { base::read_keys(node, keys, link); });
  if (link.type == LinkType::kUdp && link.local.empty() && link.remote.empty()) {
    node.fail("needs local, remote or both");
  }
  if (link.type == LinkType::kSerial) settle_pace(node, link);
  base::read_keys(node, kCommonKeys, link);
  if (link.sniffer) settle_sniffer(node, link);
  link.accept.vehicles = link.type == LinkType::kTlog && !link.commands;
  node.reject_unused();
  return link;
}

std::vector<base::KeyRow> link_rows(std::optional<LinkType> type) {
  std::vector<base::KeyRow> rows;
  const auto add = [&](const auto& keys) { base::add_rows(keys, LinkConfig{}, rows); };
  if (type) {
    with_keys_of(*type, add);
  } else {
    add(kHeadKeys);
    add(kCommonKeys);
  }
  return rows;
}

std::vector<std::string> changed_keys(const LinkConfig& link) {
  LinkConfig standard;
  standard.type = link.type;
  set_defaults_of_type(standard);
  standard.accept.vehicles = link.accept.vehicles;
  standard.pace = !link.baud.empty();
  std::vector<std::string> changed;
  const auto add = [&](const auto& keys) { base::add_changed_keys(keys, link, standard, changed); };
  with_keys_of(link.type, add);
  add(kCommonKeys);
  return changed;
}

}  // namespace cas::casd
