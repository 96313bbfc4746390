// SPDX-License-Identifier: BSD-3-Clause
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <iostream>
#include <nlohmann/json.hpp>

#include "base/cli/manual.hpp"
#include "base/cli/parse.hpp"
#include "base/rpc/local_port.hpp"
#include "base/rpc/message.hpp"
#include "casd/casctl/completion_words.hpp"
#include "casd/casctl/doctor/doctor.hpp"
#include "casd/casctl/monitor/monitor_screen.hpp"
#include "casd/casctl/session/text.hpp"
#include "casd/casctl/verbs/verbs.hpp"

namespace cas::casctl {
namespace {

using base::rpc::CallError;
using base::rpc::ConnectionError;
using nlohmann::json;

void add_options(CommandLine& line) {
  CLI::App& app = line.app();
  Options& options = line.options();
  app.description("Commands and watches vehicles through a running casd.");
  app.name("casctl");
  app.set_version_flag("--version", std::string("casctl ") + CAS_VERSION);
  app.require_subcommand(1);
  app.add_option("--address", options.address,
                 "Command port of casd, HOST:PORT or unix:PATH; without it the one casd that runs "
                 "on this machine (several are listed), else 127.0.0.1:" +
                     std::to_string(base::rpc::kCommandPort))
      ->check([](const std::string& address) {
        const std::string fault = base::rpc::address_fault(address);
        return fault.empty() ? fault : "'" + address + "' " + fault;
      })
      ->envname("CASD_ADDRESS");
  app.add_option("--token-file", options.token_file,
                 "File with the command port's token; over TCP to this machine casd's own is found")
      ->envname("CASD_TOKEN_FILE");
  app.add_option("--vehicle", options.vehicle, "System id; needed when casd knows several")
      ->check(CLI::Range(1, 255));
  app.add_flag("--json", options.json, "Print the answer as JSON");
  app.add_flag("--wait", options.wait,
               "Also wait for casd, for the vehicle, and until the state is reached (airborne, "
               "landed), each for --timeout")
      ->disable_flag_override();  // --wait=5 would wait for 60 s
  app.add_option("--timeout", options.timeout_s, "Seconds to wait for an answer or a state")
      ->check(CLI::Range(0.1, 86400.0))
      ->capture_default_str();
  app.footer(
      "Exit codes: 0 done and acknowledged, 1 refused, 2 usage, 3 no daemon, 4 timeout (also of "
      "--wait).\n"
      "`casctl VERB --help` has an example for each verb.");
}

void print_error(const Options& options, int code, const std::string& message,
                 const std::string& data) {
  if (!options.json) {
    std::cerr << "casctl: " << printable_lines(message) << '\n';
    return;
  }
  json error{{"code", code}, {"message", message}};
  const json parsed = json::parse(data, nullptr, false);
  if (!parsed.is_discarded() && !parsed.is_null()) error["data"] = parsed;
  std::cout << json{{"error", error}}.dump() << '\n';
}

/// Sockets of casd that are there and that this user may not use.
std::string unusable_sockets() {
  std::string text;
  for (const std::filesystem::path& path : base::rpc::local_command_sockets()) {
    if (::access(path.c_str(), R_OK | W_OK) == 0) continue;
    text += ", or get the right to " + path.string() + " (sudo adduser $USER cas, log in again)";
  }
  return text;
}

/// Advice where casd's own sentence has none.
std::string hint(int code) {
  switch (code) {
    case base::rpc::kNotAuthorised:
      return "; give --token-file or CASD_TOKEN_FILE" + unusable_sockets();
    case base::rpc::kMethodNotFound:
      return "; casctl and casd are of different versions";
    case base::rpc::kTimeout:
      return "; is the vehicle's link up? See `casctl links`";
    default:
      return "";
  }
}

std::string first_line(const std::string& text) { return text.substr(0, text.find('\n')); }

/// Exit code for a call that was answered with an error.
int exit_code(const Options& options, int error) {
  // With --wait a vehicle that is not there was waited for until the time was over.
  const bool waited_in_vain = options.wait && error == base::rpc::kNoSuchVehicle;
  return error == base::rpc::kTimeout || waited_in_vain ? kTimeout : kRefused;
}

int run_verb(const CommandLine& line) {
  const Options& options = line.options();
  try {
    return line.run();
  } catch (const CallError& error) {
    print_error(options, error.code(), error.what() + hint(error.code()), error.data_json());
    return exit_code(options, error.code());
  } catch (const ConnectionError& error) {
    const bool late = error.timeout();
    const std::string next =
        late ? std::string("; a longer --timeout waits longer")
             : "; is casd running there? Start it with `casd TOPOLOGY.yaml`, or give --address";
    print_error(options, 0, error.what() + next, "");
    return late ? kTimeout : kNoDaemon;
  } catch (const SeveralDaemons& error) {
    const std::string what = options.json ? first_line(error.what()) : error.what();
    print_error(options, 0, what, error.daemons().dump());
    return kUsage;
  } catch (const WaitTimeout& error) {
    print_error(options, 0, error.what(), "");
    return kTimeout;
  } catch (const nlohmann::json::exception&) {
    print_error(options, 0, "casd's answer is not what this casctl reads: are they of one version?",
                "");
    return kRefused;
  } catch (const std::exception& error) {
    print_error(options, 0, error.what(), "");
    return kRefused;
  }
}

}  // namespace
}  // namespace cas::casctl

int main(int argc, char** argv) try {
  using namespace cas::casctl;
  std::signal(SIGPIPE, SIG_DFL);
  CommandLine line;
  add_options(line);
  add_status_verbs(line);
  add_flight_verbs(line);
  add_param_verbs(line);
  add_watch_verb(line);
  add_message_verb(line);
  add_link_verbs(line);
  add_service_verbs(line);
  add_monitor_verb(line, completion_words());
  add_doctor_verb(line);
  add_words_verb(line);
  line.app().get_subcommand("words")->group("");  // not in the help: for shells
  cas::base::cli::add_manual(line.app(), "casctl", CAS_VERSION, completion_words());
  if (const auto ended = cas::base::cli::parse(line.app(), argc, argv, kUsage)) return *ended;
  return run_verb(line);
} catch (const std::exception& error) {  // no memory to read the command line
  std::fprintf(stderr, "casctl: %s\n", error.what());
  return cas::casctl::kUsage;
}
