// SPDX-License-Identifier: BSD-3-Clause
#include "casd/topology/router_import.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <filesystem>
#include <map>
#include <optional>

#include "base/os/host_port.hpp"
#include "base/suggestion.hpp"
#include "base/text.hpp"
#include "casd/topology/endpoint_conflict.hpp"
#include "casd/topology/endpoint_notation.hpp"
#include "casd/topology/link_name.hpp"
#include "casd/topology/router_config.hpp"
#include "casd/topology/topology.hpp"

namespace cas::casd {
namespace {

constexpr unsigned kDefaultTcpServerPort = 5760;
constexpr unsigned kDefaultBaud = 115200;
constexpr std::uint64_t kLongestDuplicateWindow_ms = 60'000;  // of a topology

using base::lower;

/// An IPv6 address needs brackets before its port; mavlink-router's files have them or not.
std::string bracketed(const std::string& host) {
  return host.find(':') == host.npos || host.starts_with('[') ? host : "[" + host + "]";
}

struct ImportedEndpoint {
  LinkConfig link;
  std::string more;                           ///< further keys of the entry, ", key: value"
  std::string accept;                         ///< keys of its `accept`
  std::vector<std::uint32_t> only_systems{};  ///< AllowSrcSysIn
  bool sniffs = false;
  const RouterSection* section = nullptr;  ///< nullptr: the TCP server
  RouterFilters filters;
};

class Import {
 public:
  explicit Import(const std::vector<RouterFile>& files) : config_(files) {}

  ImportedTopology topology() {
    for (RouterSection& section : config_.sections()) take(section);
    add_tcp_server();
    if (endpoints_.empty()) config_.fail({0, 1}, "has no endpoint");
    choose_sniffer();
    note_unused();
    std::ranges::stable_sort(notes_, {}, &Note::place);
    ImportedTopology imported{text(), {}};
    for (const Note& each : notes_) imported.notes.push_back(each.text);
    return imported;
  }

 private:
  struct Note {
    RouterPlace place;
    std::string text;
  };

  /// Text of the file must not control a terminal or end a comment.
  void note(RouterPlace place, const std::string& sentence) {
    notes_.push_back({place, printable(config_.prefix(place) + sentence)});
  }
  static std::string printable(std::string text) {
    for (char& c : text) {
      if (static_cast<unsigned char>(c) < ' ' || c == 0x7F) c = '?';
    }
    return text;
  }

  void take(RouterSection& section) {
    if (section.kind == "general") {
      take_general(section);
    } else if (section.kind == "uartendpoint") {
      take_uart(section);
    } else if (section.kind == "udpendpoint") {
      take_udp(section);
    } else if (section.kind == "tcpendpoint") {
      take_tcp(section);
    } else {
      constexpr std::array<std::string_view, 4> kKinds{"general", "uartendpoint", "udpendpoint",
                                                       "tcpendpoint"};
      const std::string near = base::nearest_word(section.kind, kKinds);
      if (!near.empty()) {  // a link would be missing
        config_.fail(section.place,
                     "[" + section.kind + "] is no section; did you mean [" + near + "]?");
      }
      note(section.place, "[" + section.kind + "] is no section that mavlink-router has");
      for (auto& [key, value] : section.values) value.used = true;
    }
  }

  void take_general(RouterSection& section) {
    tcp_server_port_ = config_.port(section, "TcpServerPort").value_or(kDefaultTcpServerPort);
    if (const RouterValue* sniffer = config_.find(section, "SnifferSysid")) {
      sniffer_ = static_cast<unsigned>(config_.number(sniffer->text, *sniffer, 255));
      sniffer_place_ = sniffer->place;
    }
    if (const RouterValue* period = config_.find(section, "DeduplicationPeriod")) {
      duplicate_window_ms_ = config_.number(period->text, *period, kLongestDuplicateWindow_ms);
    }
    take_log(section);
  }

  void take_log(RouterSection& section) {
    const bool telemetry = config_.flag(section, "LogTelemetry");
    const RouterValue* folder = config_.find(section, "Log");
    const RouterValue* mode = config_.find(section, "LogMode");
    const RouterValue* space = config_.find(section, "MinFreeSpace");
    const RouterValue* files = config_.find(section, "MaxLogFiles");
    if (folder == nullptr) {
      for (const char* key :
           {"LogTelemetry", "LogMode", "MinFreeSpace", "MaxLogFiles", "LogSystemId"}) {
        const RouterValue* value = config_.find(section, key);
        if (value != nullptr) note(value->place, value->key + ": nothing is recorded without Log");
      }
      return;
    }
    log_ = "log:\n  folder: " + yaml_string(folder->text) + "\n";
    const bool armed = mode != nullptr && lower(mode->text) == "while-armed";
    if (mode != nullptr && !armed && lower(mode->text) != "always") {
      config_.fail(mode->place, "LogMode: is always or while-armed");
    }
    std::string autopilot = armed ? "while_armed: true" : "while_armed: false";
    if (telemetry) log_ += armed ? "  while_armed: true\n" : "  tlog: flight\n";
    const std::uint64_t most =
        files == nullptr ? 0 : config_.number(files->text, *files, 1'000'000);
    log_ += kept_logs(space, most);
    if (const RouterValue* system = config_.find(section, "LogSystemId")) {
      const std::string id = std::to_string(config_.number(system->text, *system, 255));
      if (id != "0") autopilot += ", systems: [" + id + "]";
      if (telemetry) note(system->place, "LogSystemId: a .tlog has every system");
    }
    if (most > 0 && telemetry) {
      note(files->place, "MaxLogFiles: so many .tlog and so many logs of autopilots");
    }
    log_ += "  autopilot: {" + autopilot + "}\n";
  }

  /// mavlink-router has no limit of their size. A block `keep` has old logs deleted.
  std::string kept_logs(const RouterValue* space, std::uint64_t most_files) const {
    if (space == nullptr && most_files == 0) return "";
    std::string keep = "max_mib: 0";
    if (space != nullptr) {
      constexpr std::uint64_t kMib = 1024 * 1024;
      const std::uint64_t bytes = config_.number(space->text, *space, UINT64_MAX - kMib);
      keep += fmt::format(", free_space_min_mib: {}", (bytes + kMib - 1) / kMib);
    }
    if (most_files > 0) keep += fmt::format(", max_files: {}", most_files);
    return "  keep: {" + keep + "}\n";
  }

  void take_uart(RouterSection& section) {
    ImportedEndpoint endpoint;
    endpoint.link.type = LinkType::kSerial;
    endpoint.link.device = config_.required(section, "Device");
    endpoint.link.baud = {kDefaultBaud};
    if (const RouterValue* baud = config_.find(section, "Baud")) {
      endpoint.link.baud.clear();
      for (const unsigned rate : config_.numbers(*baud, 12'000'000)) {
        std::vector<unsigned>& rates = endpoint.link.baud;
        if (std::find(rates.begin(), rates.end(), rate) == rates.end()) rates.push_back(rate);
      }
      if (endpoint.link.baud.empty()) config_.fail(baud->place, "Baud: is empty");
    }
    endpoint.link.pass_unknown = true;
    if (config_.flag(section, "FlowControl")) endpoint.more += ", flow_control: true";
    add(section, std::move(endpoint));
  }

  std::string host_of(RouterSection& section) {
    const std::string host = config_.required(section, "Address");
    const std::string bare =
        host.starts_with('[') && host.ends_with(']') ? host.substr(1, host.size() - 2) : host;
    if (!base::is_host_text(bare)) {
      config_.fail(config_.find(section, "Address")->place,
                   "Address: '" + host + "' is not a host");
    }
    return bracketed(host);
  }

  /// Port of a peer, never 0; nullopt when the key is missing.
  std::optional<unsigned> remote_port(RouterSection& section) {
    const std::optional<unsigned> port = config_.port(section, "Port");
    if (port == 0)
      config_.fail(config_.find(section, "Port")->place, "Port: of a peer is 1 to 65535");
    return port;
  }

  void take_udp(RouterSection& section) {
    const std::string address = host_of(section);
    const std::string mode = lower(config_.required(section, "Mode"));
    ImportedEndpoint endpoint;
    if (mode == "server" || mode == "eavesdropping") {
      const std::optional<unsigned> given = config_.port(section, "Port");
      if (!given) config_.fail(section.place, "endpoint '" + section.name + "' has no Port");
      endpoint.link.type = LinkType::kUdpServer;
      endpoint.link.local = fmt::format("{}:{}", address, *given);
    } else if (mode == "normal" || mode == "client") {
      std::optional<unsigned> given = remote_port(section);
      if (!given) given = next_udp_port(address, links_so_far());
      endpoint.link.type = LinkType::kUdp;
      endpoint.link.remote = fmt::format("{}:{}", address, *given);
    } else {
      config_.fail(config_.find(section, "Mode")->place,
                   "Mode: is normal, client, server or eavesdropping");
    }
    add(section, std::move(endpoint));
  }

  std::vector<LinkConfig> links_so_far() const {
    std::vector<LinkConfig> links;
    for (const ImportedEndpoint& endpoint : endpoints_) links.push_back(endpoint.link);
    return links;
  }

  void take_tcp(RouterSection& section) {
    ImportedEndpoint endpoint;
    endpoint.link.type = LinkType::kTcp;
    config_.required(section, "Port");
    endpoint.link.remote = fmt::format("{}:{}", host_of(section), *remote_port(section));
    if (const RouterValue* retry = config_.find(section, "RetryTimeout")) {
      const bool never = retry->text == "0" || retry->text.starts_with('-');
      note(retry->place, never ? "RetryTimeout: casd connects again, where mavlink-router would not"
                               : "RetryTimeout: casd tries again after 0.05 to 1 s");
    }
    add(section, std::move(endpoint));
  }

  void add(RouterSection& section, ImportedEndpoint endpoint) {
    endpoint.section = &section;
    endpoint.link.name = free_name(section.name.empty() ? section.kind : section.name);
    const std::vector<LinkConfig> others = links_so_far();
    if (const auto conflict = endpoint_conflict(endpoint.link, others)) {
      config_.fail(section.place, "endpoint '" + section.name + "': " + *conflict);
    }
    if (const LinkConfig* same = link_to_same_peer(endpoint.link, others)) {
      note(section.place, "endpoint '" + section.name + "' sends to " + endpoint.link.remote +
                              ", as '" + same->name + "' does: each packet arrives there twice");
    }
    if (const RouterValue* group = config_.find(section, "Group")) {
      endpoint.more += ", group: " + yaml_string(group->text);
    }
    std::string& accept = endpoint.accept;
    const auto accept_ids = [&](const char* key, const RouterConfig::Ids& list, bool messages) {
      if (!list.empty()) accept += (accept.empty() ? "" : ", ") + id_list(key, list, messages);
    };
    accept_ids("messages", config_.messages(section, "AllowMsgIdIn"), true);
    const RouterConfig::Ids systems = config_.sources(section, "AllowSrcSysIn");
    accept_ids("systems", systems, false);
    endpoint.only_systems.assign(systems.begin(), systems.end());
    accept_ids("block_systems", config_.sources(section, "BlockSrcSysIn"), false);

    RouterFilters& filters = endpoint.filters;
    filters.allow_messages_out = config_.messages(section, "AllowMsgIdOut");
    filters.allow_messages_out.merge(config_.messages(section, "Filter"));
    filters.block_messages_out = config_.messages(section, "BlockMsgIdOut");
    filters.block_messages_in = config_.messages(section, "BlockMsgIdIn");
    filters.allow_systems_out = config_.sources(section, "AllowSrcSysOut");
    filters.block_systems_out = config_.sources(section, "BlockSrcSysOut");
    filters.allow_components_out = config_.sources(section, "AllowSrcCompOut");
    filters.block_components_out = config_.sources(section, "BlockSrcCompOut");
    filters.allow_components_in = config_.sources(section, "AllowSrcCompIn");
    filters.block_components_in = config_.sources(section, "BlockSrcCompIn");
    endpoints_.push_back(std::move(endpoint));
  }

  std::string free_name(const std::string& wanted) const {
    std::string name = wanted == "any" ? "any_" : wanted.substr(0, kLongestLinkName);
    std::ranges::replace_if(
        name,
        [](const char& c) {
          return !is_link_name({&c, 1});
        },
        '_');
    const auto taken = [&] {
      return std::any_of(endpoints_.begin(), endpoints_.end(),
                         [&](const ImportedEndpoint& each) { return each.link.name == name; });
    };
    while (taken()) name += "_";
    return name;
  }

  void add_tcp_server() {
    if (tcp_server_port_ == 0) return;
    ImportedEndpoint endpoint;
    const std::string open = ", where TCP clients are served (TcpServerPort=0: none are)";
    endpoint.link.type = LinkType::kTcpServer;
    endpoint.link.name = free_name("tcp");
    endpoint.link.local = fmt::format("0.0.0.0:{}", tcp_server_port_);
    for (const ImportedEndpoint& each : endpoints_) {
      if (!endpoint_conflict(endpoint.link, std::vector{each.link})) continue;
      config_.fail(each.section->place,
                   "endpoint '" + each.link.name + "' meets " + endpoint.link.local + open);
    }
    endpoints_.push_back(std::move(endpoint));
  }

  /// mavlink-router's sniffer is the endpoint on which a system id is heard; casd knows its own
  /// before anybody says anything. So it has to be the endpoint that takes in this system alone.
  void choose_sniffer() {
    if (sniffer_ == 0) return;
    const std::string id = std::to_string(sniffer_);
    const auto is_alone = [&](const ImportedEndpoint& each) {
      return each.link.type != LinkType::kSerial && each.only_systems == std::vector{sniffer_};
    };
    const auto found = std::find_if(endpoints_.begin(), endpoints_.end(), is_alone);
    if (found == endpoints_.end()) {
      note(sniffer_place_,
           "SnifferSysid: in casd a sniffer is a link, not whoever has system id " + id +
               ": add {name: sniffer, type: udp_server, local: '127.0.0.1:PORT', sniffer: true} "
               "and connect it there");
      return;
    }
    found->more = ", sniffer: true";
    found->accept.clear();
    found->sniffs = true;
    note(sniffer_place_, "SnifferSysid: link '" + found->link.name +
                             "' gets every packet; nothing that it sends is taken in");
    for (const auto& [key, value] : found->section->values) {
      const bool is_filter = key.starts_with("allow") || key.starts_with("block");
      if ((!is_filter && key != "filter" && key != "group") || key == "allowsrcsysin") continue;
      note(value.place, value.key + ": has no effect at a sniffer");
    }
  }

  void note_unused() {
    static const std::map<std::string, std::string> kReasons{
        {"reportstats", "casctl status and casctl monitor show them at any time"},
        {"debugloglevel", "casd has --log-level"},
        {"mavlinkdialect", "casd knows all public dialects; another one: dialect"},
    };
    for (const RouterSection& section : config_.sections()) {
      for (const auto& [key, value] : section.values) {
        if (value.used) continue;
        const auto reason = kReasons.find(key);
        note(value.place,
             value.key + ": " + (reason == kReasons.end() ? "is unknown" : reason->second));
      }
    }
  }

  std::string duplicate_window() const {
    if (duplicate_window_ms_ == 0) return "";
    return fmt::format("duplicate_window_ms: {}\n", duplicate_window_ms_);
  }

  std::string routes() const {
    std::string text;
    for (const ImportedEndpoint& to : endpoints_) {
      if (to.sniffs) continue;
      std::map<std::string, std::string> senders;  // rule -> names
      for (const ImportedEndpoint& from : endpoints_) {
        if (&from == &to || from.sniffs) continue;
        std::string& names = senders[rule_between(from.filters, to.filters)];
        names += (names.empty() ? "" : ", ") + yaml_string(from.link.name);
      }
      // Each client of a TCP server is an endpoint of its own; a list of names leaves that out.
      if (to.link.type == LinkType::kTcpServer) {
        const std::string name = yaml_string(to.link.name);
        text +=
            "  - {from: " + name + ", to: " + name + rule_between(to.filters, to.filters) + "}\n";
      }
      for (const auto& [filters, names] : senders) {
        text += "  - {from: [" + names + "], to: " + yaml_string(to.link.name) + filters + "}\n";
      }
    }
    if (text.empty()) return "";
    return "# No sensor data of a simulator goes through; a bench has a topology of its own. casd "
           "leaves\n# out the link that a packet came from: links that lead to the same systems "
           "need one group.\nroutes:\n" +
           text;
  }

  /// Another one than casd's usual, if an endpoint listens there.
  std::string command_port() const {
    CommandPortConfig port;
    const auto is_taken = [&] {
      return std::ranges::any_of(endpoints_, [&](const ImportedEndpoint& each) {
        return endpoint_conflict(each.link, port).has_value();
      });
    };
    if (!is_taken()) return "";
    const auto usual = port.port;
    while (is_taken()) ++port.port;
    return fmt::format(
        "# An endpoint listens at casd's usual port {}.\ncommand_port: {{port: {}}}\n", usual,
        port.port);
  }

  std::string text() const {
    std::string text = "# From";
    for (const RouterFile& file : config_.files()) {
      text += " " + printable(std::filesystem::path(file.name).filename().string());
    }
    text += " of mavlink-router.\n";
    for (const Note& each : notes_) text += "# " + each.text + "\n";
    text +=
        "schema: 1\n"
        "# mavlink-router says nothing of its own. With a rate here, vehicles see a ground "
        "station;\n# with ask_on_sight casd asks them for what its commands need.\n"
        "commanding: {heartbeat_hz: 0, ask_on_sight: false}\n" +
        duplicate_window() + command_port() + log_ + "links:\n";
    for (const ImportedEndpoint& endpoint : endpoints_) {
      std::string entry = link_entry(endpoint.link);
      std::string more = endpoint.more;
      if (!endpoint.accept.empty()) more += ", accept: {" + endpoint.accept + "}";
      entry.insert(entry.size() - 1, more);
      text += "  " + entry + "\n";
    }
    return text + routes();
  }

  RouterConfig config_;
  std::vector<ImportedEndpoint> endpoints_;
  std::vector<Note> notes_;
  std::string log_;
  std::uint64_t duplicate_window_ms_ = 0;
  unsigned tcp_server_port_ = kDefaultTcpServerPort;
  unsigned sniffer_ = 0;  ///< system id; 0: none
  RouterPlace sniffer_place_;
};

}  // namespace

ImportedTopology import_mavlink_router(const std::vector<RouterFile>& files) {
  return Import(files).topology();
}

}  // namespace cas::casd
