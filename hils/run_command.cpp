// SPDX-License-Identifier: BSD-3-Clause
#include "hils/run_command.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <future>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/cli/keys_flag.hpp"
#include "base/cli/whole_number.hpp"
#include "base/config/install_paths.hpp"
#include "base/error.hpp"
#include "base/os/result_file.hpp"
#include "base/text.hpp"
#include "hils/bench/fly.hpp"
#include "hils/boards/board_error.hpp"
#include "hils/boards/board_flags.hpp"
#include "hils/boards/flight_boards.hpp"
#include "hils/mcap/run_mcap.hpp"
#include "hils/measure/figure_table.hpp"
#include "hils/measure/judgement.hpp"
#include "hils/measure/run_result.hpp"
#include "hils/programs/live_run.hpp"
#include "hils/replay/replay_command.hpp"
#include "hils/replay/replay_page.hpp"
#include "hils/report/junit_report.hpp"
#include "hils/report/results_folder.hpp"
#include "hils/report/run_report.hpp"
#include "hils/run/folder_lock.hpp"
#include "hils/run/scratch_folder.hpp"
#include "hils/run/station_endpoint.hpp"
#include "hils/scenario/scenario.hpp"
#include "hils/scenario_list.hpp"
#include "hils/sweep/key_path.hpp"
#include "hils/ulog/run_ulog.hpp"

namespace cas::hils {

namespace {

struct Flags {
  std::string scenario;
  std::string architecture;
  std::optional<std::uint64_t> seed;
  std::vector<std::string> fcus;  ///< as parse_fcu_words() takes them
  std::optional<unsigned> fcu_baud;
  BoardFlags boards;
  std::string out;
  std::string ground_station;
  bool inject_failures = false;
  std::vector<std::string> plugin_dirs;
  std::vector<std::string> settings;  ///< KEY=VALUE
  bool only_check = false;
  bool beside_paper = false;
  bool on_virtual_clock = false;
  bool lockstep = false;
  bool web = false;
  bool mcap = false;
};

/// Puts folders before those of CAS_PLUGIN_PATH, for this process and those that it starts.
/// @throws base::ConfigError "FOLDER: no such folder"
void search_plugins_in(const std::vector<std::string>& folders) {
  std::string path;
  for (const std::string& folder : folders) {
    if (!std::filesystem::is_directory(folder)) {
      throw base::ConfigError("--plugin-dir " + folder + ": no such folder");
    }
    path += std::filesystem::absolute(folder).string() + ":";
  }
  if (path.empty()) return;
  const char* before = std::getenv("CAS_PLUGIN_PATH");
  ::setenv("CAS_PLUGIN_PATH", (path + (before != nullptr ? before : "")).c_str(), 1);
}

/// Names the report and writes the replay. A run without a replay keeps its verdict.
void leave_replay(const RunRequest& request, const RunResult& result, const std::string& out) {
  fmt::print("Report:  {}\n", (std::filesystem::path(out) / "report.html").string());
  std::fflush(stdout);
  try {
    if (write_replay(request, result).empty()) {
      fmt::print("Replay:  {}\n", why_no_page());
    } else {
      fmt::print("Replay:  {}\n", (std::filesystem::path(out) / "replay.html").string());
    }
  } catch (const std::exception& error) {
    fmt::print(stderr, "hils: the replay was not written: {}\n", error.what());
  }
}

/// Chooses the next free out/NAME, after the scenario's file, where there is no --out.
/// @throws base::ConfigError
void choose_folder(Flags& flags, const std::filesystem::path& file) {
  if (!flags.out.empty()) return make_results_folder(std::filesystem::absolute(flags.out));
  const std::string name = file.stem().string();
  const std::filesystem::path folder =
      "out" / make_next_folder(std::filesystem::absolute("out"), name).filename();
  flags.out = folder.string();
  if (folder.filename() == name) return;
  fmt::print(stderr, "hils: out/{} is taken: the results go to {}\n", name, flags.out);
}

/// The folder of a run, which it holds, without what an earlier run left there.
/// @throws base::ConfigError
std::filesystem::path take_folder(Flags& flags, const std::filesystem::path& file,
                                  std::optional<FolderLock>& lock) {
  if (lock) return std::filesystem::absolute(flags.out);
  choose_folder(flags, file);
  std::filesystem::path out = std::filesystem::absolute(flags.out);
  lock.emplace(out);
  clear_earlier_run(out);
  return out;
}

/// Values of --set by their paths of keys. @throws base::ConfigError
std::vector<KeyValue> parse_settings(const std::vector<std::string>& words) {
  std::vector<KeyValue> values;
  for (const std::string& word : words) {
    const std::size_t split = word.find('=');
    if (split == std::string::npos || split == 0) {
      throw base::ConfigError(
          fmt::format("--set {}: is not KEY=VALUE, such as line.packet_loss=0.1", word));
    }
    values.emplace_back(word.substr(0, split), word.substr(split + 1));
  }
  return values;
}

/// Takes the boards of a run, its folder, and waits until the boards have booted; a board's error
/// becomes the case of a junit.xml. A run whose boards are not even named rightly leaves no folder.
/// @throws BoardError, RunStopped, base::ConfigError
void prepare_boards(const std::vector<FcuChoice>& fcus, Flags& flags, RunRequest& request,
                    std::optional<FolderLock>& lock, std::optional<FlightBoards>& boards) {
  try {
    boards.emplace(fcus, flags.boards.file(), "hils run " + flags.scenario,
                   flags.boards.patience());
    request.out = take_folder(flags, request.scenario.file, lock);
    request.fcu_devices = boards->prepare(request.out, request.scenario.names(), flags.fcu_baud);
  } catch (const BoardError& error) {
    request.out = take_folder(flags, request.scenario.file, lock);
    const Verdict verdict{.failures = {error.what()}};
    base::write_result({request.out, "junit.xml"},
                       junit_report("hils." + request.scenario.name, 0, verdict));
    throw;
  }
}

/// Refuses flags that the controller or the clock of a run cannot heed.
/// @throws base::ConfigError for the first
void refuse_flags(const Flags& flags, const RunRequest& request) {
  const std::optional<Firmware>& firmware = request.scenario.firmware;
  const bool on_line = firmware && firmware->on_serial_line;
  const bool is_computed = request.is_computed();
  const bool has_fcu = !flags.fcus.empty();
  const bool has_station = !flags.ground_station.empty();
  struct Refusal {
    bool applies;
    const char* flag;
    const char* why;
  };
  const Refusal refusals[] = {
      {firmware && flags.on_virtual_clock, "--virtual",
       "stock firmware is a program, and computes in time of its own"},
      {on_line && flags.lockstep, "--lockstep", "stock firmware on a serial line waits for nobody"},
      {firmware && !flags.architecture.empty(), "--architecture",
       "stock firmware is connected as its topology says"},
      {firmware && !on_line && has_fcu, "--fcu",
       "this stock firmware is a program without a serial line; for a board take px4_hitl.yaml, "
       "ardupilot_hil.yaml or pixhawk.yaml"},
      {firmware && flags.inject_failures && firmware->autopilot != "PX4", "--inject-failures",
       "stock firmware other than PX4 has no link of casd to its simulator"},
      {is_computed && flags.lockstep, "--lockstep",
       "a run on the virtual clock (--virtual or architecture direct) has no programs to keep in "
       "step"},
      {is_computed && has_fcu, "--fcu", "a real controller cannot be flown on the virtual clock"},
      {is_computed && has_station, "--gcs",
       "a ground station cannot join a run on the virtual clock"},
      {is_computed && flags.web, "--web", "only a run in real time is shown in a browser"},
      {flags.lockstep && has_fcu, "--fcu",
       "a real controller has a clock of its own and no place in lockstep"},
      {flags.lockstep && has_station, "--gcs",
       "a ground station has a clock of its own and no place in lockstep"},
      {flags.lockstep && flags.web, "--web", "only a run in real time is shown in a browser"},
  };
  for (const auto& [applies, flag, why] : refusals) {
    if (applies) throw base::ConfigError(fmt::format("{}: {}: {}", flags.scenario, flag, why));
  }
}

/// @throws base::ConfigError for flags that do not fit each other
RunRequest read_request(const Flags& flags, const std::filesystem::path& file) {
  RunRequest request;
  request.scenario = Scenario::load(file);
  request.architecture = flags.architecture.empty() ? request.scenario.architecture
                                                    : parse_architecture(flags.architecture);
  request.seed = flags.seed.value_or(request.scenario.seed);
  if (flags.lockstep) request.clock = Clock::kLockstep;
  if (flags.on_virtual_clock) request.clock = Clock::kVirtual;
  refuse_flags(flags, request);
  if (!flags.ground_station.empty()) {
    request.station = StationEndpoint::parse(flags.ground_station);
    request.station->inject_failures = flags.inject_failures;
  }
  request.announced = true;
  request.beside_paper = flags.beside_paper;
  return request;
}

void write_ulogs(const RunRequest& request, const RunResult& result) {
  for (std::size_t i = 0; i < result.vehicles.size(); ++i) {
    write_ulog(request, result.vehicles[i].record, i);
  }
}

/// What is wrong with a changed copy, said of the scenario and the keys that the user named: the
/// copy is gone when they read it, and its lines are not theirs.
std::string said_of_copy(std::string sentence, const Flags& flags,
                         const std::filesystem::path& folder) {
  std::string words = flags.scenario + " with --set " + base::joined(flags.settings, " --set ");
  const std::string copies = folder.string() + "/";
  if (sentence.starts_with(copies)) {
    const std::size_t colon = sentence.find(':', copies.size());
    const std::string copy = sentence.substr(copies.size(), colon - copies.size());
    // A file that the scenario names is copied as KEY_NAME.
    if (copy != "scenario.yaml") words += ", in " + copy.substr(copy.find('_') + 1);
    sentence.erase(0, std::min(colon, sentence.size()));
    const std::size_t line = sentence.find_first_not_of("0123456789", 1);
    if (line > 1 && line < sentence.size() && sentence[line] == ':') sentence.erase(0, line);
  } else {
    if (sentence.starts_with(flags.scenario + ":")) sentence.erase(0, flags.scenario.size() + 1);
    words += ": ";
    sentence.erase(0, std::min(sentence.find_first_not_of(' '), sentence.size()));
  }
  const std::string here = std::filesystem::current_path().string();
  for (std::size_t at = 0; (at = sentence.find(folder.string(), at)) != std::string::npos;) {
    sentence.replace(at, folder.string().size(), here);
    at += here.size();
  }
  return words + sentence;
}

/// Reads the scenario as --set changes it, from a copy in `folder`.
/// @throws base::ConfigError that names the scenario and the settings
RunRequest read_changed(const Flags& flags, const std::filesystem::path& file,
                        const std::filesystem::path& folder) {
  const std::vector<KeyValue> values = parse_settings(flags.settings);
  try {
    write_scenario(file, values, std::filesystem::current_path(), folder);
    return read_request(flags, folder / "scenario.yaml");
  } catch (const base::ConfigError& error) {
    throw base::ConfigError(said_of_copy(error.what(), flags, folder));
  }
}

/// Reads a scenario as these flags have it, and leaves nothing. Plugins, models and programs are
/// looked at by a flight alone.
RunRequest read_only(const Flags& flags, const std::filesystem::path& file) {
  if (flags.settings.empty()) return read_request(flags, file);
  const ScratchFolder scratch(std::filesystem::temp_directory_path(), "hils-check");
  return read_changed(flags, file, scratch.path());
}

int run(Flags flags) {
  search_plugins_in(flags.plugin_dirs);
  const std::filesystem::path file = base::find_config(flags.scenario);
  RunRequest request = read_only(flags, file);
  if (flags.only_check) {
    parse_fcu_words(flags.fcus, request.scenario.names());
    fmt::print("{}: no error in the keys of {} or in the flags\n", flags.scenario,
               request.scenario.name);
    return kExitPassed;
  }
  std::optional<FolderLock> lock;
  if (!flags.settings.empty()) {  // a refused one has left no folder
    const std::filesystem::path folder = take_folder(flags, file, lock) / "run/scenario";
    request = read_changed(flags, file, folder);
  }
  std::optional<LiveRun> live;
  if (flags.web) request.live = &live.emplace();
  std::optional<FlightBoards> boards;
  prepare_boards(parse_fcu_words(flags.fcus, request.scenario.names()), flags, request, lock,
                 boards);

  RunResult result = evaluate(request, fly(request));
  for (const std::string& setting : flags.settings) {
    result.verdict.remarks.push_back("set by --set: " + setting);
  }
  fail_absent(boards->absences(), result);
  if (live) live->tell(result);
  // Each reads the same records and writes files of its own.
  auto results = std::async(std::launch::async, [&] { write_results(request, result); });
  auto logs = std::async(std::launch::async, [&] { write_ulogs(request, result); });
  auto recording = flags.mcap ? std::async(std::launch::async, [&] { write_mcap(request, result); })
                              : std::future<void>();
  const std::string report = write_text(run_lines(result, request.beside_paper));
  results.get();
  fmt::print("{}\nResults: {}\n", report, flags.out);
  leave_replay(request, result, flags.out);
  logs.get();
  if (recording.valid()) recording.get();
  boards->fetch_logs(request.out, request.scenario.names());
  return result.verdict.exit_code();
}

}  // namespace

base::cli::Verb add_run(CLI::App& app) {
  const auto kept = std::make_shared<Flags>();
  Flags& flags = *kept;
  CLI::App* command = app.add_subcommand("run", "Fly one scenario");
  base::cli::add_keys_flag(*command, scenario_reference, "a scenario");
  base::cli::add_reference_flag(*command, "--figures", figure_reference,
                                "Print every figure with its key, unit, direction and meaning");
  command->add_flag_callback(
      "--list",
      [] {
        std::fputs(list_scenarios().c_str(), stdout);
        throw CLI::Success();
      },
      "List the shipped scenarios with the controller that flies each, and end");
  command->add_option("SCENARIO", flags.scenario, "Scenario file")->required();
  command->add_option("--architecture", flags.architecture,
                      "One of direct, sitl, ts, loop or tcas");
  command->add_flag("--virtual", flags.on_virtual_clock,
                    "Compute time instead of waiting for it: exact and fast");
  command->add_flag(
      "--lockstep", flags.lockstep,
      "Run the real processes on the stream's time: repeatable to the byte, and fast; stock "
      "firmware in software as fast as it goes");
  command
      ->add_option("--out", flags.out,
                   "Folder for the results (the last, if several), cleared of an earlier run; "
                   "without it out/SCENARIO, or the next free out/SCENARIO-2, ...")
      ->take_last();
  command
      ->add_option(
          "--fcu", flags.fcus,
          "A real controller instead of the emulator, or of a stock firmware on a serial line: a "
          "board of boards.yaml, or the path of a serial port; of several vehicles VEHICLE=BOARD, "
          "once for each")
      ->allow_extra_args(false);
  command->add_option("--fcu-baud", flags.fcu_baud,
                      "Baud rate of that port (the board's, or 921600)");
  add_board_flags(*command, flags.boards);
  CLI::Option* const station =
      command->add_option("--gcs", flags.ground_station,
                          "Lets a ground station join: udp:PORT sends to one at 127.0.0.1:PORT and "
                          "hears it, udp_server:PORT and tcp_server:PORT listen for it; also "
                          "TYPE:HOST:PORT. In real time only");
  command
      ->add_flag("--inject-failures", flags.inject_failures,
                 "Lets that ground station inject failures (MAV_CMD_INJECT_FAILURE), which strike "
                 "in the simulator")
      ->needs(station);
  command->add_flag("--web", flags.web,
                    "Show the run in a browser: starts casweb and prints the address");
  command->add_flag("--mcap", flags.mcap,
                    "Write the run as MCAP, too: flight.mcap, for Foxglove and `hils replay`");
  command->add_option("--plugin-dir", flags.plugin_dirs,
                      "Folder searched for plugins first, before CAS_PLUGIN_PATH");
  command
      ->add_option("--set", flags.settings,
                   "KEY=VALUE: another value for a key of the scenario, or of a file that it names "
                   "(line.packet_loss=0.1, plugins[wind].mean_m_s=8, "
                   "vehicle.rotor.omega_max_rad_s=800); may be repeated")
      ->allow_extra_args(false);
  command->add_flag("--paper", flags.beside_paper,
                    "Show the figures of [HILS] Tables 4 and 5 below those of the run");
  command->add_flag(
      "--check", flags.only_check,
      "Read the scenario with these flags, say what is wrong in its keys, and end; plugins, "
      "models and programs are looked at by a flight alone");
  command->add_option("--seed", flags.seed, "Seed instead of the scenario's")
      ->check(base::cli::whole_number);
  return {command, [kept] { return run(*kept); }};
}

}  // namespace cas::hils
