// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <csignal>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <sstream>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "base/cli/keys_flag.hpp"
#include "base/cli/manual.hpp"
#include "base/cli/parse.hpp"
#include "base/config/config_document.hpp"
#include "base/config/install_paths.hpp"
#include "base/error.hpp"
#include "base/os/command_port.hpp"
#include "base/os/cpu_latency.hpp"
#include "base/os/program.hpp"
#include "base/os/thread.hpp"
#include "base/printable.hpp"
#include "base/read_file.hpp"
#include "base/rpc/token.hpp"
#include "base/text.hpp"
#include "casd/app.hpp"
#include "casd/port/message_decoder.hpp"
#include "casd/signing/packet_signer.hpp"
#include "casd/station/gain_map.hpp"
#include "casd/topology/endpoint_conflict.hpp"
#include "casd/topology/endpoint_notation.hpp"
#include "casd/topology/injection.hpp"
#include "casd/topology/router_import.hpp"
#include "casd/topology/topology.hpp"
#include "casd/topology/topology_files.hpp"
#include "casd/topology/topology_text.hpp"

namespace cas::casd {
namespace {

/// Reads the other files that a topology names (token, keys, dialect, gains). @throws
/// base::ConfigError
void check_named_files(const Topology& topology) {
  const std::filesystem::path& token = topology.command_port.token_file;
  std::error_code unknown;
  const bool is_there = !token.empty() && std::filesystem::exists(token, unknown);
  if (is_there || unknown) base::rpc::read_token(token);
  for (const LinkConfig& link : topology.links) {
    if (link.signing) read_signing_key(link.signing->key_file);
  }
  if (!topology.dialect.empty()) {
    MessageDecoder decoder;
    add_dialect(topology.dialect, decoder);
  }
  if (!topology.gains.empty()) GainMap::load(topology.gains);
}

struct Flags {
  std::vector<std::string> places;  ///< one topology, or endpoints
  std::vector<std::string> masters;
  std::vector<std::string> outs;
  std::vector<std::string> tcp_peers;
  std::vector<int> tcp_ports;
  unsigned baud = 0;  ///< of serial endpoints without a rate; 0: none
  EndpointLog log;
  int command_port = -1;
  bool silent = false;
  bool as_topology = false;
  std::string import_file;
  std::string import_folder;  ///< empty: config.d beside the file
  std::string ledger;
  std::string stats;
  std::string name;
  std::string log_level = "info";
  bool check = false;
  bool lockstep = false;
};

bool is_topology(const std::string& place) {
  std::error_code none;
  return !is_endpoint(place) || std::filesystem::is_regular_file(place, none) ||
         std::filesystem::is_directory(place, none);
}

/// The links that the command line itself describes. @throws base::ConfigError
std::vector<LinkConfig> endpoints_of(const Flags& flags) {
  std::vector<LinkConfig> links;
  for (const std::string& text : flags.places) {
    if (is_topology(text)) {
      const std::string line = text.starts_with('/') ? "; a terminal is 'serial:" + text + "'" : "";
      throw base::ConfigError("'" + text + "' is not an endpoint; a topology file stands alone" +
                              line);
    }
    links.push_back(parse_endpoint(text));
  }
  for (const std::string& text : flags.masters) {
    links.push_back(parse_endpoint(text, EndpointUse::kMaster));
  }
  for (const std::string& text : flags.outs) {
    links.push_back(parse_endpoint(text, EndpointUse::kOut, links));
  }
  for (const std::string& text : flags.tcp_peers) links.push_back(parse_endpoint("tcpout:" + text));
  for (const int port : flags.tcp_ports) {
    if (port == 0) continue;
    links.push_back(parse_endpoint("tcpin:" + std::to_string(port)));
  }
  for (auto link = links.begin(); link != links.end(); ++link) {
    if (link_to_same_peer(*link, {links.begin(), link}) == nullptr) continue;
    throw base::ConfigError("two endpoints send to " + link->remote +
                            ": each packet would arrive there twice");
  }
  for (LinkConfig& link : links) {
    if (link.type != LinkType::kSerial || !link.baud.empty()) continue;
    const unsigned rate = flags.baud != 0 ? flags.baud : usual_baud(link.device);
    if (rate != 0) link.baud = {rate};
  }
  return links;
}

/// Users of mavlink-router hand its file over as they are used to.
void refuse_router_file(const std::filesystem::path& file) {
  std::error_code none;
  if (file.extension() != ".conf" || !std::filesystem::is_regular_file(file, none)) return;
  std::istringstream text(base::read_foreign_file(file, "topology", base::kMaxConfigBytes));
  for (std::string line; std::getline(text, line);) {
    const std::string_view words = base::trimmed(line);
    if (words.empty() || words.front() == '#') continue;
    if (words.front() == '[' && words.back() == ']') {
      throw base::ConfigError(file.string() +
                              ": is mavlink-router's configuration? 'casd --import " +
                              file.string() + " > topology.yaml' reads it");
    }
    return;
  }
}

/// A topology from a file or folder, or made of the command line's endpoints.
struct TopologySource {
  std::filesystem::path place;  ///< empty: endpoints
  std::string name;             ///< for people
  std::vector<base::ConfigNode> files;
  Topology topology;
};

/// @throws base::ConfigError
TopologySource read_topology(const Flags& flags) {
  if (flags.log.telemetry && flags.log.folder.empty()) {
    throw base::ConfigError("--telemetry-log needs --log FOLDER");
  }
  const bool has_options = !flags.masters.empty() || !flags.outs.empty() ||
                           !flags.tcp_peers.empty() || !flags.tcp_ports.empty() ||
                           !flags.log.folder.empty() || flags.baud != 0;
  if (flags.places.size() == 1 && is_topology(flags.places[0])) {
    if (flags.as_topology || flags.command_port >= 0) {
      throw base::ConfigError("--as-topology and --command-port go with endpoints; '" +
                              flags.places[0] + "' is a topology already");
    }
    if (flags.silent) {
      throw base::ConfigError(
          "--silent goes with endpoints; a topology has commanding: {heartbeat_hz: 0, "
          "ask_on_sight: false}");
    }
  }
  if (flags.places.size() == 1 && is_topology(flags.places[0]) && !has_options) {
    const std::filesystem::path place = base::find_config(flags.places[0]);
    refuse_router_file(place);
    std::vector<base::ConfigNode> files = load_topology_files(place);
    Topology topology = Topology::parse(files);
    return {place, flags.places[0], std::move(files), std::move(topology)};
  }
  const std::vector<LinkConfig> links = endpoints_of(flags);
  if (links.empty()) {
    throw base::ConfigError(
        "no topology: give a file, or endpoints such as serial:/dev/ttyACM0:921600 udp:14550");
  }
  const std::string text = topology_of_endpoints(
      links, {.command_port = flags.command_port, .silent = flags.silent, .log = flags.log});
  const std::string name = "the command line";
  Topology topology = Topology::parse(base::ConfigNode::parse(text, name));
  if (flags.as_topology) std::fputs(text.c_str(), stdout);
  return {{}, name, {}, std::move(topology)};
}

/// Prints casd's topology for mavlink-router's file, and notes on its keys also to stderr.
/// @throws base::ConfigError
int print_import(const Flags& flags) {
  const bool alone = flags.places.empty() && flags.masters.empty() && flags.outs.empty() &&
                     flags.tcp_peers.empty() && flags.tcp_ports.empty() && !flags.check &&
                     !flags.silent && flags.log.folder.empty();
  if (!alone) {
    throw base::ConfigError(
        "--import prints a topology and ends: 'casd --import FILE > "
        "topology.yaml', then 'casd --check topology.yaml'");
  }
  const ImportedTopology imported =
      import_mavlink_router(read_router_files(flags.import_file, flags.import_folder));
  Topology::parse(base::ConfigNode::parse(imported.yaml, "the imported topology"));
  std::fputs(imported.yaml.c_str(), stdout);
  for (const std::string& note : imported.notes) std::fprintf(stderr, "%s\n", note.c_str());
  return base::kExitOk;
}

int run(const Flags& flags) {
  std::signal(SIGXFSZ, SIG_IGN);  // a file as large as it may be ends a recording, not casd
  if (!flags.import_file.empty()) return print_import(flags);
  if (!flags.import_folder.empty()) {
    throw base::ConfigError(
        "--conf-dir goes with --import FILE, which prints a topology; "
        "a topology has a folder FILE.d of its own");
  }
  auto [place, source_name, files, topology] = read_topology(flags);
  if (flags.as_topology) return base::kExitOk;
  if (flags.lockstep) topology.set_lockstep();
  if (flags.check) {
    check_named_files(topology);
    std::string text = fmt::format("{}: {} links, {} routes\n", source_name, topology.links.size(),
                                   topology.routes.size());
    if (files.size() > 1) text += "files, each over those before it\n";
    for (std::size_t i = 0; files.size() > 1 && i < files.size(); ++i) {
      text += "  " + files[i].file().string() + "\n";
    }
    text += topology_text(topology);
    for (const std::string& warning : injection_warnings(topology)) {
      text += "warning: " + warning + "\n";
    }
    std::fputs(base::printable_lines(text).c_str(), stdout);
    return base::kExitOk;
  }
  if (topology.runs_in_real_time()) base::lock_memory();
  const base::CpuLatencyRequest latency(topology.cpu_dma_latency_us);
  App app({.topology_file = place,
           .ledger_file = flags.ledger,
           .stats_file = flags.stats,
           .name = flags.name,
           .lockstep = flags.lockstep},
          std::move(topology));
  base::bind_command_port([&app] { app.listen(); });
  app.run();
  return base::kExitOk;
}

/// An option of another router's that casd does not take.
struct ForeignOption {
  const char* names;
  bool has_value;
  const char* sentence;      ///< its replacement
  bool is_left_out = false;  ///< with a warning: packets go where they would go with it
};

constexpr std::array kForeignOptions{
    ForeignOption{"-c,--conf-file", true,
                  "'casd --import FILE > topology.yaml' reads mavlink-router's file, and "
                  "'casd topology.yaml' runs it"},
    ForeignOption{"-r,--report_msg_statistics", false,
                  "'casctl status' and 'casctl monitor' show figures at any time", true},
    ForeignOption{"-s,--sniffer-sysid", true,
                  "a link of a topology with 'sniffer: true' gets every packet"},
    ForeignOption{"-y,--syslog", false,
                  "casd writes to standard error, which systemd's journal keeps", true},
    // of MAVProxy and mavp2p
    ForeignOption{"--streamrate,--streamreq-frequency", true,
                  "'request_rates' of a link asks its vehicles for messages, each with its rate",
                  true},
    ForeignOption{"--streamreq-disable", false, "'--silent' has casd ask for no streams"},
    ForeignOption{"--hb-disable", false, "'--silent' has casd send no HEARTBEAT"},
    ForeignOption{"--rtscts", false, "'serial_flowcontrol:DEVICE:BAUD' is a line with RTS/CTS"},
    ForeignOption{"--hb-version", true, "casd speaks MAVLink 2, and passes both versions on", true},
    ForeignOption{"--source-component,--hb-componentid", true,
                  "'component_id' of a topology is casd's own"},
    ForeignOption{"--source-system,--hb-systemid", true, "'system_id' of a topology is casd's own"},
    ForeignOption{"--hb-period", true,
                  "'commanding: {heartbeat_hz: HZ}' of a topology sets the rate"},
    ForeignOption{"--daemon", false, "a service of systemd runs casd (docs/use/operations.md)"},
    ForeignOption{"--aircraft,--logfile,--dump-path,--dump-duration", true,
                  "'--log FOLDER' records", true},
    ForeignOption{"--dump", false, "'--log FOLDER --telemetry-log' records"},
    ForeignOption{"--print,--console", false,
                  "'casctl monitor' and 'casctl message' show what goes through", true},
    ForeignOption{"--map", false, "'casweb' shows vehicles", true},
    ForeignOption{"--cmd", true, "'casctl' has a verb for each command"},
    ForeignOption{"--quiet", false, "'--log-level warn' says less", true},
    ForeignOption{"--mav20,--mav10", false, "casd passes both versions on", true},
    ForeignOption{"--non-interactive", false, "casd reads no keyboard", true},
    ForeignOption{"--dialect", true,
                  "casd knows all public dialects; another one: 'dialect' of a topology"}};

/// A value that was forgotten: the next flag would be taken for a host or a folder.
std::string refuse_flag(const std::string& value) {
  return value.starts_with('-') ? "'" + value + "' is a flag, and no value" : "";
}

/// Warns of one that is given. @throws CLI::ParseError when it would have moved packets
void add_foreign_options(CLI::App& cli) {
  for (const ForeignOption& each : kForeignOptions) {
    const auto answer = [&each](const std::string& value) {
      const std::string sentence = std::string("is not casd's: ") + each.sentence;
      if (!each.is_left_out) throw CLI::ValidationError(each.names, sentence);
      const std::string given = value.empty() ? "" : " (" + value + ")";
      std::fprintf(stderr, "warning: %s%s %s\n", each.names, given.c_str(), sentence.c_str());
    };
    CLI::Option* option = each.has_value
                              ? cli.add_option_function<std::string>(each.names, answer)
                              : cli.add_flag_callback(each.names, [answer] { answer(""); });
    if (each.has_value) option->expected(0, 1);  // the sentence, with or without a value
    option->group("");                           // neither in the help nor in the manual
  }
}

/// The topology, or the endpoints that one is made of.
void add_topology_options(CLI::App& cli, Flags& flags) {
  cli.add_option("topology", flags.places,
                 "A file with links and routes (YAML; FILE.d/*.yaml overlay it), a folder of such "
                 "files, or endpoints: serial:DEVICE:BAUD, udp:PORT, udp:HOST:PORT, tcp:PORT, "
                 "tcp:HOST:PORT, mcast:")
      ->type_name("TOPOLOGY|ENDPOINT...");
  // One value each: mavlink-router's and MAVProxy's users write options before their endpoints.
  const auto one_each = [](CLI::Option* option) { return option->allow_extra_args(false); };
  one_each(cli.add_option("--master", flags.masters, "A vehicle's endpoint, as MAVProxy writes it"))
      ->type_name("ENDPOINT");
  one_each(cli.add_option("--out,-e,--endpoints", flags.outs,
                          "Send by UDP to HOST:PORT, as MAVProxy and mavlink-router do; without a "
                          "port to 14550 or the next one"))
      ->type_name("HOST[:PORT]")
      ->check(refuse_flag);
  one_each(cli.add_option("-p,--tcp-endpoint", flags.tcp_peers, "Connect by TCP to HOST:PORT"))
      ->type_name("HOST:PORT");
  one_each(cli.add_option("-t,--tcp-port", flags.tcp_ports,
                          "Listen for TCP clients of this machine; 0: no"))
      ->type_name("PORT");
  cli.add_option("--baudrate", flags.baud, "Rate of serial endpoints that name none")
      ->check(CLI::Range(300U, 12'000'000U))
      ->type_name("BAUD");
  cli.add_option("-l,--log", flags.log.folder,
                 "With endpoints: record the autopilots' logs into this folder")
      ->type_name("FOLDER")
      ->check(refuse_flag);
  cli.add_flag("-T,--telemetry-log", flags.log.telemetry, "With --log: record telemetry, too");
  cli.add_option("--command-port", flags.command_port,
                 "TCP port for casctl, with endpoints; 0: a free one")
      ->check(CLI::Range(0, 65535));
  cli.add_flag(
      "--silent", flags.silent,
      "With endpoints: no HEARTBEAT of casd's own and no questions to vehicles that appear, "
      "as mavlink-router does (--log still asks for logs)");
}

/// What is printed in place of a run.
void add_printing_options(CLI::App& cli, Flags& flags) {
  cli.add_flag("--as-topology", flags.as_topology,
               "Print the endpoints as a topology file, and end");
  cli.add_flag("--check", flags.check, "Read the topology, say what is wrong, and end");
  base::cli::add_keys_flag(cli, topology_reference, "a topology");
  cli.add_option("--import", flags.import_file,
                 "Print mavlink-router's configuration (with config.d beside the file) as a "
                 "topology file, and end")
      ->type_name("MAIN.CONF");
  cli.add_option("-d,--conf-dir", flags.import_folder,
                 "With --import: another folder than config.d beside the file")
      ->type_name("FOLDER");
}

void add_run_options(CLI::App& cli, Flags& flags) {
  cli.add_option("--ledger", flags.ledger,
                 "Write each HIL packet at each link to this file at the end");
  cli.add_flag("--lockstep", flags.lockstep,
               "Run every protocol timer on the stream's time, as 'pace: lockstep' does");
  cli.add_option("--stats", flags.stats, "Write figures to this file at the end");
  cli.add_option("--name", flags.name,
                 "Name of this casd, shown where several run on this machine (`casctl --address`)");
  cli.add_option("-g,--log-level,--debug-log-level", flags.log_level,
                 "Level: debug, info, warn, error or off")
      ->transform([](const std::string& level) {  // mavlink-router's words
        return level == "warning" ? "warn" : level == "trace" ? "debug" : level;
      });
  cli.add_flag_callback(
      "-v,--verbose", [&flags] { flags.log_level = "debug"; }, "As --log-level debug");
}

}  // namespace
}  // namespace cas::casd

int main(int argc, char** argv) try {
  using namespace cas;
  casd::Flags flags;
  CLI::App cli("Routes MAVLink between simulator, flight controller and ground stations.", "casd");
  cli.set_version_flag("-V,--version", std::string("casd ") + CAS_VERSION);
  casd::add_topology_options(cli, flags);
  casd::add_printing_options(cli, flags);
  casd::add_run_options(cli, flags);
  casd::add_foreign_options(cli);
  base::cli::add_manual(cli, "casd", CAS_VERSION);
  if (const auto ended = base::cli::parse(cli, argc, argv, base::kExitConfig)) return *ended;
  return base::run_program("casd", flags.log_level, [&] { return casd::run(flags); });
} catch (const std::exception& error) {  // no memory for the command line
  std::fprintf(stderr, "casd: internal error: %s\n", error.what());
  return cas::base::kExitInternal;
}
