// SPDX-License-Identifier: BSD-3-Clause
#include "casd/topology/router_import.hpp"

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <list>
#include <map>
#include <optional>
#include <set>
#include <system_error>

#include "base/error.hpp"
#include "base/read_file.hpp"
#include "base/text.hpp"
#include "casd/topology/endpoint_conflict.hpp"
#include "casd/topology/endpoint_notation.hpp"
#include "casd/topology/topology.hpp"
#include "mavlink_gen/runtime/public_table.hpp"

namespace cas::casd {
namespace {

constexpr unsigned kDefaultTcpServerPort = 5760;
constexpr unsigned kDefaultBaud = 115200;

using base::lower;
using base::trimmed;

/// An IPv6 address needs brackets before its port; mavlink-router's files have them or not.
std::string bracketed(const std::string& host) {
  return host.find(':') == host.npos || host.starts_with('[') ? host : "[" + host + "]";
}

struct Place {
  std::size_t file = 0;
  int line = 0;
};

struct Value {
  std::string key;  ///< as the file spells it
  std::string text;
  Place place;
  bool used = false;
};

struct Section {
  std::string kind;  ///< lower case: "general", "uartendpoint", ...
  std::string name;
  Place place;
  std::map<std::string, Value> values;  ///< by the key in lower case
};

using Ids = std::set<std::uint32_t>;

/// What one endpoint lets in and out, as far as a route says it.
struct Filters {
  Ids allow_messages_out, block_messages_out, block_messages_in;
  Ids allow_systems_out, block_systems_out;
  Ids allow_components_out, block_components_out, allow_components_in, block_components_in;
};

struct Endpoint {
  LinkConfig link;
  std::string more;                           ///< further keys of the entry, ", key: value"
  std::string accept;                         ///< keys of its `accept`
  std::vector<std::uint32_t> only_systems{};  ///< AllowSrcSysIn
  bool sniffs = false;
  Filters filters;
};

class Import {
 public:
  explicit Import(const std::vector<RouterFile>& files) : files_(files) {
    for (place_.file = 0; place_.file < files_.size(); ++place_.file)
      read(files_[place_.file].text);
  }

  ImportedTopology topology() {
    for (Section& section : sections_) take(section);
    add_tcp_server();
    if (endpoints_.empty()) fail({0, 1}, "has no endpoint");
    choose_sniffer();
    note_unused();
    return {text(), notes_};
  }

 private:
  std::string words(Place place) const {
    return files_[place.file].name + ":" + std::to_string(place.line) + ": ";
  }
  [[noreturn]] void fail(Place place, const std::string& sentence) const {
    throw base::ConfigError(words(place) + sentence);
  }

  /// Text of the file must not control a terminal or end a comment.
  void note(Place place, const std::string& sentence) {
    notes_.push_back(printable(words(place) + sentence));
  }
  static std::string printable(std::string text) {
    for (char& c : text) {
      if (static_cast<unsigned char>(c) < ' ' || c == 0x7F) c = '?';
    }
    return text;
  }

  void read(std::string_view text) {
    section_ = nullptr;
    for (place_.line = 1; !text.empty(); ++place_.line) {
      const std::size_t end = std::min(text.find('\n'), text.size());
      read_line(trimmed(text.substr(0, end)));
      text.remove_prefix(std::min(end + 1, text.size()));
    }
  }

  void read_line(std::string_view text) {
    if (text.empty() || text.front() == '#' || text.front() == ';') return;
    if (text.front() == '[') {
      if (text.back() != ']') fail(place_, "a section ends with ]");
      const std::string_view head = trimmed(text.substr(1, text.size() - 2));
      const std::size_t blank = std::min(head.find_first_of(" \t"), head.size());
      open_section(lower(head.substr(0, blank)), std::string(trimmed(head.substr(blank))));
      return;
    }
    const std::size_t equals = text.find('=');
    if (equals == text.npos) fail(place_, "is neither [section] nor key = value");
    if (section_ == nullptr) fail(place_, "a key stands before the first section");
    const std::string key(trimmed(text.substr(0, equals)));
    section_->values[lower(key)] = {key, std::string(trimmed(text.substr(equals + 1))), place_,
                                    false};
  }

  /// A section that comes again goes on, in another file too; names have any case.
  void open_section(const std::string& kind, const std::string& name) {
    const auto same = [&](const Section& each) {
      return each.kind == kind && lower(each.name) == lower(name);
    };
    auto found = std::find_if(sections_.begin(), sections_.end(), same);
    if (found == sections_.end()) {
      found = sections_.insert(sections_.end(), {kind, name, place_, {}});
    }
    section_ = &*found;
  }

  static Value* find(Section& section, std::string_view key) {
    const auto found = section.values.find(lower(key));
    if (found == section.values.end()) return nullptr;
    found->second.used = true;
    return &found->second;
  }

  std::string required(Section& section, std::string_view key) {
    const Value* value = find(section, key);
    if (value == nullptr || value->text.empty()) {
      fail(section.place, "endpoint '" + section.name + "' has no " + std::string(key));
    }
    return value->text;
  }

  std::uint64_t number(std::string_view digits, const Value& value, std::uint64_t most) const {
    std::uint64_t result = 0;
    const char* end = digits.data() + digits.size();
    const auto [stop, error] = std::from_chars(digits.data(), end, result);
    if (error != std::errc{} || stop != end) {
      fail(value.place, value.key + ": '" + std::string(digits) + "' is not a number");
    }
    if (result > most) fail(value.place, value.key + ": is more than " + std::to_string(most));
    return result;
  }

  std::vector<std::uint32_t> numbers(const Value& value, std::uint32_t most) const {
    std::vector<std::uint32_t> list;
    std::string_view rest = value.text;
    while (!rest.empty()) {
      const std::size_t comma = std::min(rest.find(','), rest.size());
      list.push_back(
          static_cast<std::uint32_t>(number(trimmed(rest.substr(0, comma)), value, most)));
      rest.remove_prefix(std::min(comma + 1, rest.size()));
    }
    return list;
  }

  Ids ids(Section& section, std::string_view key, std::uint32_t most) {
    const Value* value = find(section, key);
    if (value == nullptr) return {};
    const auto list = numbers(*value, most);
    return {list.begin(), list.end()};
  }
  Ids messages(Section& section, std::string_view key) { return ids(section, key, 0xFFFFFF); }
  Ids sources(Section& section, std::string_view key) { return ids(section, key, 255); }

  std::optional<unsigned> port(Section& section, std::string_view key) {
    const Value* value = find(section, key);
    if (value == nullptr) return std::nullopt;
    return static_cast<unsigned>(number(value->text, *value, 65535));
  }

  bool flag(Section& section, std::string_view key) {
    const Value* value = find(section, key);
    if (value == nullptr) return false;
    const std::string word = lower(value->text);
    if (word == "true" || word == "yes" || word == "1" || word == "on") return true;
    if (word == "false" || word == "no" || word == "0" || word == "off") return false;
    fail(value->place, value->key + ": is true or false");
  }

  void take(Section& section) {
    if (section.kind == "general") {
      take_general(section);
    } else if (section.kind == "uartendpoint") {
      take_uart(section);
    } else if (section.kind == "udpendpoint") {
      take_udp(section);
    } else if (section.kind == "tcpendpoint") {
      take_tcp(section);
    } else {
      note(section.place, "[" + section.kind + "] is no section that mavlink-router has");
      for (auto& [key, value] : section.values) value.used = true;
    }
  }

  void take_general(Section& section) {
    tcp_server_port_ = port(section, "TcpServerPort").value_or(kDefaultTcpServerPort);
    if (const Value* sniffer = find(section, "SnifferSysid")) {
      sniffer_ = static_cast<unsigned>(number(sniffer->text, *sniffer, 255));
      sniffer_place_ = sniffer->place;
    }
    const bool telemetry = flag(section, "LogTelemetry");
    const Value* folder = find(section, "Log");
    const Value* mode = find(section, "LogMode");
    const Value* space = find(section, "MinFreeSpace");
    const Value* files = find(section, "MaxLogFiles");
    if (folder == nullptr) {
      for (const char* key : {"LogTelemetry", "LogMode", "MinFreeSpace", "MaxLogFiles"}) {
        const Value* value = find(section, key);
        if (value != nullptr) note(value->place, value->key + ": nothing is recorded without Log");
      }
      return;
    }
    log_ = "log:\n  folder: " + yaml_string(folder->text) + "\n";
    const bool armed = mode != nullptr && lower(mode->text) == "while-armed";
    std::string autopilot = armed ? "while_armed: true" : "while_armed: false";
    if (telemetry) log_ += armed ? "  while_armed: true\n" : "  tlog: flight\n";
    constexpr std::uint64_t kMib = 1024 * 1024;
    if (space != nullptr) {
      const std::uint64_t bytes = number(space->text, *space, UINT64_MAX - kMib);
      const std::string key = "free_space_min_mib: " + std::to_string((bytes + kMib - 1) / kMib);
      log_ += "  " + key + "\n";
      autopilot += ", " + key;
      note(space->place, "MinFreeSpace: casd pauses a recording there; it deletes no older ones");
    }
    log_ += "  autopilot: {" + autopilot + "}\n";
    if (files == nullptr) return;
    if (const std::uint64_t most = number(files->text, *files, 1'000'000); most > 0) {
      log_ += "  max_files: " + std::to_string(most) + "\n";
      note(files->place, "MaxLogFiles: of .tlog files; casd deletes no log of an autopilot");
    }
  }

  void take_uart(Section& section) {
    Endpoint endpoint;
    endpoint.link.type = LinkType::kSerial;
    endpoint.link.device = required(section, "Device");
    endpoint.link.baud = {kDefaultBaud};
    if (const Value* baud = find(section, "Baud")) {
      endpoint.link.baud.clear();
      for (const unsigned rate : numbers(*baud, 12'000'000)) {
        std::vector<unsigned>& rates = endpoint.link.baud;
        if (std::find(rates.begin(), rates.end(), rate) == rates.end()) rates.push_back(rate);
      }
      if (endpoint.link.baud.empty()) fail(baud->place, "Baud: is empty");
    }
    endpoint.link.pass_unknown = true;
    if (flag(section, "FlowControl")) endpoint.more += ", flow_control: true";
    add(section, std::move(endpoint));
  }

  void take_udp(Section& section) {
    const std::string address = required(section, "Address");
    const std::string mode = lower(required(section, "Mode"));
    std::optional<unsigned> given = port(section, "Port");
    Endpoint endpoint;
    if (mode == "server" || mode == "eavesdropping") {
      if (!given) fail(section.place, "endpoint '" + section.name + "' has no Port");
      endpoint.link.type = LinkType::kUdpServer;
      endpoint.link.local = bracketed(address) + ":" + std::to_string(*given);
    } else if (mode == "normal" || mode == "client") {
      if (!given) given = next_udp_port(bracketed(address), links_so_far());
      endpoint.link.type = LinkType::kUdp;
      endpoint.link.remote = bracketed(address) + ":" + std::to_string(*given);
    } else {
      fail(find(section, "Mode")->place, "Mode: is normal, client, server or eavesdropping");
    }
    add(section, std::move(endpoint));
  }

  std::vector<LinkConfig> links_so_far() const {
    std::vector<LinkConfig> links;
    for (const Endpoint& endpoint : endpoints_) links.push_back(endpoint.link);
    return links;
  }

  void take_tcp(Section& section) {
    Endpoint endpoint;
    endpoint.link.type = LinkType::kTcp;
    required(section, "Port");
    endpoint.link.remote =
        bracketed(required(section, "Address")) + ":" + std::to_string(*port(section, "Port"));
    if (const Value* retry = find(section, "RetryTimeout")) {
      const bool never = retry->text == "0" || retry->text.starts_with('-');
      note(retry->place, never ? "RetryTimeout: casd connects again, where mavlink-router would not"
                               : "RetryTimeout: casd tries again after 0.05 to 1 s");
    }
    add(section, std::move(endpoint));
  }

  void add(Section& section, Endpoint endpoint) {
    endpoint.link.name = free_name(section.name.empty() ? section.kind : section.name);
    if (const Value* group = find(section, "Group")) {
      endpoint.more += ", group: " + yaml_string(group->text);
    }
    std::string& accept = endpoint.accept;
    const auto accept_ids = [&](const char* key, const Ids& list, bool messages) {
      if (!list.empty()) accept += (accept.empty() ? "" : ", ") + listed(key, list, messages);
    };
    accept_ids("messages", messages(section, "AllowMsgIdIn"), true);
    const Ids systems = sources(section, "AllowSrcSysIn");
    accept_ids("systems", systems, false);
    endpoint.only_systems.assign(systems.begin(), systems.end());
    accept_ids("block_systems", sources(section, "BlockSrcSysIn"), false);

    Filters& filters = endpoint.filters;
    filters.allow_messages_out = messages(section, "AllowMsgIdOut");
    filters.allow_messages_out.merge(messages(section, "Filter"));
    filters.block_messages_out = messages(section, "BlockMsgIdOut");
    filters.block_messages_in = messages(section, "BlockMsgIdIn");
    filters.allow_systems_out = sources(section, "AllowSrcSysOut");
    filters.block_systems_out = sources(section, "BlockSrcSysOut");
    filters.allow_components_out = sources(section, "AllowSrcCompOut");
    filters.block_components_out = sources(section, "BlockSrcCompOut");
    filters.allow_components_in = sources(section, "AllowSrcCompIn");
    filters.block_components_in = sources(section, "BlockSrcCompIn");
    endpoints_.push_back(std::move(endpoint));
  }

  std::string free_name(const std::string& wanted) const {
    std::string name = wanted == "any" ? "any_" : wanted;
    const auto taken = [&] {
      return std::any_of(endpoints_.begin(), endpoints_.end(),
                         [&](const Endpoint& each) { return each.link.name == name; });
    };
    while (taken()) name += "_";
    return name;
  }

  void add_tcp_server() {
    if (tcp_server_port_ == 0) return;
    Endpoint endpoint;
    endpoint.link.type = LinkType::kTcpServer;
    endpoint.link.name = free_name("tcp");
    endpoint.link.local = "0.0.0.0:" + std::to_string(tcp_server_port_);
    endpoints_.push_back(std::move(endpoint));
  }

  /// mavlink-router's sniffer is the endpoint on which a system id is heard; casd knows its own
  /// before anybody says anything. So it has to be the endpoint that takes in this system alone.
  void choose_sniffer() {
    if (sniffer_ == 0) return;
    const std::string id = std::to_string(sniffer_);
    const auto is_alone = [&](const Endpoint& each) {
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
  }

  void note_unused() {
    static const std::map<std::string, std::string> kReasons{
        {"reportstats", "casctl status and casctl monitor show them at any time"},
        {"debugloglevel", "casd has --log-level"},
        {"deduplicationperiod", "links of one group pass on once what comes twice"},
        {"mavlinkdialect", "casd knows all public dialects; another one: dialect"},
        {"logsystemid", "casd records every system"},
    };
    for (const Section& section : sections_) {
      for (const auto& [key, value] : section.values) {
        if (value.used) continue;
        const auto reason = kReasons.find(key);
        note(value.place,
             value.key + ": " + (reason == kReasons.end() ? "is unknown" : reason->second));
      }
    }
  }

  static std::string word(std::uint32_t id, bool messages) {
    const mav::MessageInfo* known = messages ? mav::public_table().find(id) : nullptr;
    return known == nullptr ? std::to_string(id) : std::string(known->name);
  }

  static std::string listed(const char* key, const Ids& list, bool messages) {
    const auto word_of = [messages](std::uint32_t id) { return word(id, messages); };
    return std::string(key) + ": [" + base::joined(list, ", ", word_of) + "]";
  }

  /// Both ends have their say: what both allow, and nothing that one of them blocks.
  static std::string rule(const Filters& from, const Filters& to) {
    std::string text;
    const auto add = [&](const char* key, const Ids& list, bool messages) {
      if (!list.empty()) text += ", " + listed(key, list, messages);
    };
    const auto both = [](Ids one, Ids other) {
      one.merge(other);
      return one;
    };
    add("allow", to.allow_messages_out, true);
    Ids block = both(from.block_messages_in, to.block_messages_out);
    if (to.allow_messages_out.empty()) block.merge(simulator_messages());
    add("block", block, true);
    add("allow_systems", to.allow_systems_out, false);
    add("block_systems", to.block_systems_out, false);
    Ids components = both(from.allow_components_in, to.allow_components_out);
    if (!from.allow_components_in.empty() && !to.allow_components_out.empty()) {
      std::erase_if(components, [&](std::uint32_t id) {
        return !from.allow_components_in.contains(id) || !to.allow_components_out.contains(id);
      });
      if (components.empty()) return ", allow: []";  // an empty list of components is all
    }
    add("allow_components", components, false);
    add("block_components", both(from.block_components_in, to.block_components_out), false);
    return text;
  }

  /// A simulator's sensor data would fly a vehicle in HIL.
  static Ids simulator_messages() {
    Ids ids;
    for (const std::string_view name : kSimulatorMessages)
      ids.insert(mav::public_table().find(name)->id);
    return ids;
  }

  std::string routes() const {
    std::string text;
    for (const Endpoint& to : endpoints_) {
      if (to.sniffs) continue;
      std::map<std::string, std::string> senders;  // rule -> names
      for (const Endpoint& from : endpoints_) {
        if (&from == &to || from.sniffs) continue;
        std::string& names = senders[rule(from.filters, to.filters)];
        names += (names.empty() ? "" : ", ") + yaml_string(from.link.name);
      }
      // Each client of a TCP server is an endpoint of its own; a list of names leaves that out.
      if (to.link.type == LinkType::kTcpServer) {
        const std::string name = yaml_string(to.link.name);
        text += "  - {from: " + name + ", to: " + name + rule(to.filters, to.filters) + "}\n";
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
      return std::ranges::any_of(endpoints_, [&](const Endpoint& each) {
        return endpoint_conflict(each.link, port).has_value();
      });
    };
    if (!is_taken()) return "";
    const std::string usual = std::to_string(port.port);
    while (is_taken()) ++port.port;
    return "# An endpoint listens at casd's usual port " + usual +
           ".\ncommand_port: {port: " + std::to_string(port.port) + "}\n";
  }

  std::string text() const {
    std::string text = "# From";
    for (const RouterFile& file : files_) {
      text += " " + printable(std::filesystem::path(file.name).filename().string());
    }
    text += " of mavlink-router.\n";
    for (const std::string& each : notes_) text += "# " + each + "\n";
    text +=
        "schema: 1\n"
        "# mavlink-router says nothing of its own. With a rate here, vehicles see a ground "
        "station.\n"
        "commanding: {heartbeat_hz: 0}\n" +
        command_port() + log_ + "links:\n";
    for (const Endpoint& endpoint : endpoints_) {
      std::string entry = link_entry(endpoint.link);
      std::string more = endpoint.more;
      if (!endpoint.accept.empty()) more += ", accept: {" + endpoint.accept + "}";
      entry.insert(entry.size() - 1, more);
      text += "  " + entry + "\n";
    }
    return text + routes();
  }

  const std::vector<RouterFile>& files_;
  Place place_;  ///< of the line being read
  std::list<Section> sections_;
  Section* section_ = nullptr;  ///< the one being read
  std::vector<Endpoint> endpoints_;
  std::vector<std::string> notes_;
  std::string log_;
  unsigned tcp_server_port_ = kDefaultTcpServerPort;
  unsigned sniffer_ = 0;  ///< system id; 0: none
  Place sniffer_place_;
};

}  // namespace

std::vector<RouterFile> read_router_files(const std::filesystem::path& main) {
  constexpr std::size_t kMostFiles = 128;  // as mavlink-router
  std::vector<std::filesystem::path> paths;
  std::error_code error;
  std::filesystem::directory_iterator entry(main.parent_path() / "config.d", error);
  for (; !error && entry != std::filesystem::directory_iterator(); entry.increment(error)) {
    std::error_code none;
    if (std::filesystem::is_regular_file(entry->path(), none)) paths.push_back(entry->path());
    if (paths.size() > kMostFiles) {
      throw base::ConfigError(entry->path().parent_path().string() + ": has more than " +
                              std::to_string(kMostFiles) + " files");
    }
  }
  std::sort(paths.begin(), paths.end());
  paths.insert(paths.begin(), main);
  std::vector<RouterFile> files;
  for (const std::filesystem::path& path : paths) {
    const auto text = base::read_file(path);
    if (!text) throw base::ConfigError("cannot read " + path.string());
    files.push_back({path.string(), *text});
  }
  return files;
}

ImportedTopology import_mavlink_router(const std::vector<RouterFile>& files) {
  return Import(files).topology();
}

}  // namespace cas::casd
