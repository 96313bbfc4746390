// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <signal.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cctype>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/cli/keys_flag.hpp"
#include "base/cli/manual.hpp"
#include "base/cli/parse.hpp"
#include "base/cli/whole_number.hpp"
#include "base/config/install_paths.hpp"
#include "base/error.hpp"
#include "base/os/log.hpp"
#include "base/os/write_file.hpp"
#include "base/time/clock.hpp"
#include "hils/boards/board_command.hpp"
#include "hils/boards/board_error.hpp"
#include "hils/boards/flight_boards.hpp"
#include "hils/campaign/campaign_command.hpp"
#include "hils/compare/comparison.hpp"
#include "hils/compare/comparison_report.hpp"
#include "hils/firmware/firmware_run.hpp"
#include "hils/measure/judgement.hpp"
#include "hils/measure/run_result.hpp"
#include "hils/programs/live_run.hpp"
#include "hils/programs/lockstep_run.hpp"
#include "hils/programs/realtime_run.hpp"
#include "hils/programs/supervisor.hpp"
#include "hils/replay/replay_command.hpp"
#include "hils/replay/replay_page.hpp"
#include "hils/report/report.hpp"
#include "hils/report/results_folder.hpp"
#include "hils/run/station_endpoint.hpp"
#include "hils/scenario/scenario.hpp"
#include "hils/scenario/scenario_reference.hpp"
#include "hils/sweep/sweep_command.hpp"
#include "hils/timing/timing_command.hpp"
#include "hils/tune/tune_command.hpp"
#include "hils/ulog/run_ulog.hpp"
#include "hils/virtual/virtual_run.hpp"

namespace {

using namespace cas;
using namespace cas::hils;

struct RunFlags {
  std::string scenario;
  std::string architecture;
  std::optional<std::uint64_t> seed;
  std::vector<std::string> fcus;  ///< as parse_fcu_words() takes them
  std::optional<unsigned> fcu_baud;
  std::string boards;
  std::string wait;
  std::string out;
  std::string ground_station;
  bool inject_failures = false;
  std::vector<std::string> plugin_dirs;
  bool on_virtual_clock = false;
  bool lockstep = false;
  bool web = false;
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

/// Flags of `hils compare`.
struct CompareFlags {
  std::string scenario;
  std::vector<std::string> architectures{"direct", "sitl", "ts", "loop", "tcas"};
  std::vector<unsigned> bauds{460800, 921600};
  std::size_t seeds = 5;
  std::uint64_t first_seed = 1;
  double warm_up_s = 10;
  double hold_s = 60;
  bool on_virtual_clock = false;
  bool keep = false;
  bool markdown = false;
  std::string out;
};

std::vector<RunRecord> fly(const RunRequest& request, bool on_virtual_clock) {
  if (on_virtual_clock || request.architecture == Architecture::kDirect) {
    return run_on_virtual_clock(request);
  }
  if (request.lockstep) return run_in_lockstep(request);
  return run_in_real_time(request);
}

/// Says of the first flag that means nothing to stock firmware what does instead.
/// @throws base::ConfigError
void refuse_flags_of_our_controller(const RunFlags& flags) {
  const auto refuse = [&flags](bool given, const char* flag, const char* instead) {
    if (!given) return;
    throw base::ConfigError(flags.scenario + ": " + flag +
                            " has no place in a flight of stock firmware: " + instead);
  };
  refuse(flags.seed.has_value(), "--seed", "its world has `seed`");
  refuse(flags.lockstep, "--lockstep", "its world says whether it is flown in lockstep");
  refuse(flags.on_virtual_clock, "--virtual", "it has a clock of its own; its world has `speed`");
  refuse(!flags.architecture.empty(), "--architecture", "its topology says how it is connected");
  refuse(!flags.fcus.empty(), "--fcu",
         "it is started as a program; for a board take the scenario pixhawk.yaml");
  refuse(flags.fcu_baud.has_value(), "--fcu-baud", "its topology has the baud rate");
  refuse(!flags.ground_station.empty(), "--gcs", "its topology has a link for a ground station");
  refuse(flags.web, "--web", "start casweb beside it");
}

/// A run without a replay keeps its verdict.
void leave_replay(const RunRequest& request, const RunResult& result, const std::string& out) {
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

/// Takes the boards of a run and waits until they have booted; what is wrong with one is the case
/// of a junit.xml. A run whose boards are not even named rightly leaves no folder.
/// @throws BoardError, RunStopped, base::ConfigError
void prepare_boards(const std::vector<FcuChoice>& fcus, const RunFlags& flags, RunRequest& request,
                    std::optional<FlightBoards>& boards) {
  const auto clear_folder = [&request] {
    make_results_folder(request.out);
    remove_verdict(request.out);
  };
  try {
    boards.emplace(fcus, find_board_list(flags.boards), "hils run " + flags.scenario,
                   parse_wait(flags.wait));
    clear_folder();
    request.fcu_devices = boards->prepare(request.out, request.scenario.names(), flags.fcu_baud);
  } catch (const BoardError& error) {
    clear_folder();
    const Verdict verdict{.failures = {error.what()}};
    base::write_file(request.out / "junit.xml",
                     junit_report("hils." + request.scenario.name, 0, verdict),
                     base::Durability::kCache);
    throw;
  }
}

int run(const RunFlags& flags) {
  search_plugins_in(flags.plugin_dirs);
  const std::filesystem::path file = base::find_config(flags.scenario);
  if (FirmwareScenario::is(file)) {
    refuse_flags_of_our_controller(flags);
    const FirmwareScenario scenario = FirmwareScenario::load(file);
    make_results_folder(std::filesystem::absolute(flags.out));
    return fly_firmware(scenario, std::filesystem::absolute(flags.out));
  }
  RunRequest request;
  request.scenario = Scenario::load(file);
  request.architecture = flags.architecture.empty() ? request.scenario.architecture
                                                    : parse_architecture(flags.architecture);
  request.lockstep = flags.lockstep;
  if (request.lockstep &&
      (flags.on_virtual_clock || request.architecture == Architecture::kDirect)) {
    throw base::ConfigError(
        "--lockstep: a run on the virtual clock (" +
        std::string(flags.on_virtual_clock ? "--virtual" : "architecture direct") +
        ") has no programs to keep in step");
  }
  request.seed = flags.seed.value_or(request.scenario.seed);
  const std::vector<FcuChoice> fcus = parse_fcu_words(flags.fcus, request.scenario.names());
  if (!fcus.empty() && request.lockstep) {
    throw base::ConfigError("a real controller has a clock of its own and no place in lockstep");
  }
  if (!fcus.empty() && (flags.on_virtual_clock || request.architecture == Architecture::kDirect)) {
    throw base::ConfigError("a real controller cannot be flown on the virtual clock");
  }
  if (!flags.ground_station.empty()) {
    request.station = StationEndpoint::parse(flags.ground_station);
    request.station->inject_failures = flags.inject_failures;
    if (flags.on_virtual_clock || request.architecture == Architecture::kDirect) {
      throw base::ConfigError("--gcs: a ground station cannot join a run on the virtual clock");
    }
  }
  if (flags.web && (flags.on_virtual_clock || request.lockstep ||
                    request.architecture == Architecture::kDirect)) {
    throw base::ConfigError("--web: only a run in real time is shown in a browser");
  }
  std::optional<LiveRun> live;
  if (flags.web) request.live = &live.emplace();
  request.announced = true;
  request.out = std::filesystem::absolute(flags.out);
  std::optional<FlightBoards> boards;
  prepare_boards(fcus, flags, request, boards);

  RunResult result = evaluate(request, fly(request, flags.on_virtual_clock));
  fail_absent(boards->absences(), result);
  if (live) live->tell(result);
  write_results(request, result);
  for (std::size_t i = 0; i < result.vehicles.size(); ++i) {
    write_ulog(request, result.vehicles[i].record, i);
  }
  fmt::print("{}\nResults: {}\n", text_report(result), flags.out);
  std::fflush(stdout);
  leave_replay(request, result, flags.out);
  boards->fetch_logs(request.out, request.scenario.names());
  return result.verdict.exit_code();
}

ComparisonPlan make_plan(const CompareFlags& flags) {
  ComparisonPlan plan;
  plan.scenario = Scenario::load(base::find_config(flags.scenario));
  std::vector<Architecture> architectures;
  for (const std::string& word : flags.architectures) {
    architectures.push_back(parse_architecture(word));
  }
  plan.variants = make_variants(architectures, flags.bauds);
  for (std::uint64_t i = 0; i < flags.seeds; ++i) plan.seeds.push_back(flags.first_seed + i);
  plan.warm_up_s = flags.warm_up_s;
  plan.hold_s = flags.hold_s;
  plan.virtual_clock = flags.on_virtual_clock;
  if (plan.seeds.empty() || plan.variants.empty() || !(plan.hold_s > 0) || !(plan.warm_up_s > 0)) {
    throw base::ConfigError(
        "a comparison needs at least one seed and one architecture, and times above 0");
  }
  return plan;
}

/// Flies and reports a comparison. @return exit code: 0, or 3 when no run of some variant is valid
/// @throws RunStopped, base::ConfigError
int compare(const CompareFlags& flags) {
  const ComparisonPlan plan = make_plan(flags);
  const std::filesystem::path out = std::filesystem::absolute(flags.out);
  make_results_folder(out);
  std::filesystem::create_directories(out / "plots");
  const base::RunTime begin = base::steady_now();
  const std::vector<VariantResult> results = run_comparison(plan, out, flags.keep);
  const double wall_s = base::to_seconds(base::steady_now() - begin);

  base::write_file(out / "comparison.md", comparison_text(plan, results, TableStyle::kMarkdown),
                   base::Durability::kCache);
  base::write_file(out / "comparison.json", comparison_json(plan, results),
                   base::Durability::kCache);
  base::write_file(out / "comparison.html", comparison_html(plan, results),
                   base::Durability::kCache);
  for (const auto& [name, plot] : comparison_plots(results)) {
    base::write_file(out / "plots" / (name + ".svg"), to_svg(plot), base::Durability::kCache);
  }
  double simulated_s = 0;
  for (const VariantResult& result : results) {
    for (const Measurement& figures : result.runs) simulated_s += figures.simulated_s;
  }
  const bool markdown = flags.markdown || ::isatty(STDOUT_FILENO) == 0;
  const TableStyle style = markdown ? TableStyle::kMarkdown : TableStyle::kAligned;
  fmt::print("{}\n{:.0f} s simulated in {:.1f} s\nResults: {}\n",
             comparison_text(plan, results, style), simulated_s, wall_s, flags.out);
  return exit_code(results);
}

/// A sentence may quote a file: nothing in it reaches the terminal but its letters.
void tell(const std::exception& error) {
  std::string sentence = error.what();
  std::ranges::replace_if(
      sentence, [](unsigned char c) { return std::iscntrl(c) != 0 && c != '\n'; }, '?');
  fmt::print(stderr, "hils: {}\n", sentence);
}

/// Runs a command and turns what it throws into a sentence and an exit code.
int guarded(const std::function<int()>& command) {
  try {
    return command();
  } catch (const RunStopped& stopped) {
    tell(stopped);
    return stopped.interrupted() ? kExitInterrupted : kExitInvalid;
  } catch (const BoardError& error) {
    tell(error);
    return error.code();
  } catch (const base::ConfigError& error) {
    tell(error);
    return kExitUsage;
  } catch (const std::exception& error) {
    tell(error);
    return kExitInvalid;
  }
}

CLI::App* add_compare(CLI::App& app, CompareFlags& flags) {
  CLI::App* command = app.add_subcommand(
      "compare", "Fly one scenario in several architectures, as [HILS] Sect. 4 does");
  command->add_option("SCENARIO", flags.scenario, "Scenario file")->required();
  command->add_option("--architectures", flags.architectures, "Some of direct,sitl,ts,loop,tcas")
      ->delimiter(',');
  command->add_option("--baud", flags.bauds, "Of the line where there is one: 460800,921600")
      ->delimiter(',')
      ->check(CLI::IsMember({115200, 460800, 921600}));
  command->add_option("--seeds", flags.seeds, "Runs of each (5)")->check(base::cli::whole_number);
  command
      ->add_option("--first-seed", flags.first_seed,
                   "Seed of the first run; the others follow it (1)")
      ->check(base::cli::whole_number);
  command->add_option("--warm-up", flags.warm_up_s, "Seconds of hover before the measurement (10)");
  command->add_option("--hold", flags.hold_s, "Seconds measured (60)");
  command->add_flag("--virtual", flags.on_virtual_clock,
                    "Compute time instead of waiting for it: the same to the byte each time");
  command->add_flag("--markdown", flags.markdown,
                    "Print Markdown on a terminal, too, as comparison.md has it");
  command->add_flag("--keep", flags.keep, "Keep truth.csv, sensors and flight.tlog of each run");
  command->add_option("--out", flags.out, "Folder for the results (the last, if several)")
      ->required()
      ->take_last();
  return command;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Flies experiments with a controller in the loop, measures and judges them", "hils");
  app.set_version_flag("--version", "hils " + std::string(CAS_VERSION));
  app.require_subcommand(1);
  std::string log_level = "warn";
  app.add_option("--log-level", log_level, "Level: debug, info, warn, error or off");

  RunFlags flags;
  CLI::App* command = app.add_subcommand("run", "Fly one scenario");
  base::cli::add_keys_flag(*command, scenario_reference, "a scenario");
  command->add_option("SCENARIO", flags.scenario, "Scenario file")->required();
  command->add_option("--architecture", flags.architecture,
                      "One of direct, sitl, ts, loop or tcas");
  command->add_flag("--virtual", flags.on_virtual_clock,
                    "Compute time instead of waiting for it: exact and fast");
  command->add_flag(
      "--lockstep", flags.lockstep,
      "Run the real processes on the stream's time: repeatable to the byte, and fast");
  command->add_option("--out", flags.out, "Folder for the results (the last, if several)")
      ->required()
      ->take_last();
  command
      ->add_option("--fcu", flags.fcus,
                   "A real controller instead of the emulator: a board of boards.yaml, or the path "
                   "of a serial port; of several vehicles VEHICLE=BOARD, once for each")
      ->allow_extra_args(false);
  command->add_option("--fcu-baud", flags.fcu_baud,
                      "Baud rate of that port (the board's, or 921600)");
  command->add_option("--boards", flags.boards,
                      "The list of boards (CAS_BOARDS, ./boards.yaml, ~/.config/cas/boards.yaml, "
                      "/etc/cas/boards.yaml)");
  add_wait(*command, flags.wait);
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
  command->add_option("--plugin-dir", flags.plugin_dirs,
                      "Folder searched for plugins first, before CAS_PLUGIN_PATH");
  command->add_option("--seed", flags.seed, "Seed instead of the scenario's")
      ->check(base::cli::whole_number);
  CompareFlags compare_flags;
  const CLI::App* compare_command = add_compare(app, compare_flags);
  const SweepCommand sweep(app);
  const TuneCommand tune(app);
  const CampaignCommand campaign(app);
  const ReplayCommand replay(app);
  const TimingCommand timing(app);
  const BoardCommand board(app);
  base::cli::add_manual(app, "hils", std::string(CAS_VERSION), board_words());
  const std::vector<std::string_view> words(argv, argv + argc);
  if (const auto sentence = misread_wait(words)) {
    fmt::print(stderr, "hils: {}\n", *sentence);
    return kExitUsage;
  }
  if (const auto ended = base::cli::parse(app, argc, argv, kExitUsage)) return *ended;
  return guarded([&] {
    ::signal(SIGCHLD, SIG_DFL);  // inherited as ignored, it would hide how children ended
    base::log::init("hils", base::log::parse_level(log_level));
    if (sweep.parsed()) return sweep.run();
    if (tune.parsed()) return tune.run();
    if (campaign.parsed()) return campaign.run();
    if (replay.parsed()) return replay.run();
    if (timing.parsed()) return timing.run();
    if (board.parsed()) return board.run();
    return compare_command->parsed() ? compare(compare_flags) : run(flags);
  });
}
