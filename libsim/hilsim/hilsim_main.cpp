// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <sys/prctl.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <memory>
#include <new>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "base/cli/keys_flag.hpp"
#include "base/cli/manual.hpp"
#include "base/cli/parse.hpp"
#include "base/config/frame_table.hpp"
#include "base/config/install_paths.hpp"
#include "base/config/sensor_sheets.hpp"
#include "base/error.hpp"
#include "base/os/command_port.hpp"
#include "base/os/confine_files.hpp"
#include "base/os/cpu_latency.hpp"
#include "base/os/log.hpp"
#include "base/os/notify.hpp"
#include "base/os/program.hpp"
#include "base/os/result_file.hpp"
#include "base/os/thread.hpp"
#include "base/os/write_file.hpp"
#include "fcu/control/loop_table.hpp"
#include "libsim/core/load/plausibility.hpp"
#include "libsim/core/load/sim_config.hpp"
#include "libsim/core/load/simulation_reference.hpp"
#include "libsim/core/run/left_world.hpp"
#include "libsim/core/run/sim_loop.hpp"
#include "libsim/core/run/sim_runner.hpp"
#include "libsim/hilsim/confinement.hpp"
#include "libsim/hilsim/control_server.hpp"
#include "libsim/hilsim/sim_report.hpp"
#include "libsim/hilsim/vehicle_description.hpp"
#include "libsim/hilsim/wind_tunnel.hpp"

namespace {

using namespace cas;

struct Flags {
  std::filesystem::path config;
  std::optional<std::string> describe;
  std::optional<std::filesystem::path> svg;
  std::optional<std::filesystem::path> polar;
  std::vector<double> alpha{-20, 30, 1};  // deg: from, to, step
  std::vector<double> beta{0, 0, 1};
  std::optional<double> airspeed_m_s;
  std::optional<std::filesystem::path> stats;
  std::optional<std::filesystem::path> ledger;
  std::optional<std::filesystem::path> control;
  std::filesystem::path output = ".";
  std::vector<std::filesystem::path> plugin_dirs;
  std::string log_level = "info";
  std::optional<double> duration_s;
  bool ignore_missing = false;
  bool lockstep = false;
  bool paused = false;
};

void add_flags(CLI::App& app, Flags& flags) {
  CLI::Option* const config =
      app.add_option("config", flags.config, "Simulation to run (YAML); needed to run one");
  base::cli::add_keys_flag(app, sim::simulation_reference, "a simulation");
  base::cli::add_keys_flag(app, base::sensor_reference, "a sensor set", "--sensor-keys");
  CLI::Option* const describe = app.add_option("--describe", flags.describe,
                                               "Print mass, rotors, hover, effectiveness matrix, "
                                               "frame and rate loops of a vehicle (a name of "
                                               "a shipped one, or a file), or trim, stall, glide "
                                               "and modes of one with wings, and end");
  describe->excludes(config);
  app.add_option("--svg", flags.svg,
                 "With --describe: draw the vehicle from above and from the side into this file")
      ->needs(describe);
  CLI::Option* const polar =
      app.add_option("--polar", flags.polar,
                     "With --describe: measure the coefficients of a vehicle with wings in a "
                     "virtual wind tunnel, and write them into this file (CSV)")
          ->needs(describe);
  app.add_option("--alpha", flags.alpha, "With --polar: angles of attack FROM TO STEP, deg")
      ->expected(3)
      ->needs(polar);
  app.add_option("--beta", flags.beta, "With --polar: sideslips FROM TO STEP, deg")
      ->expected(3)
      ->needs(polar);
  app.add_option("--airspeed", flags.airspeed_m_s, "With --polar: m/s; default: cruise_m_s")
      ->check(CLI::PositiveNumber)
      ->needs(polar);
  app.add_option("--stats", flags.stats, "Write figures (JSON) to this file at the end");
  app.add_option("--ledger", flags.ledger,
                 "Write each vehicle's packet ledger (CSV), below --output; with several vehicles "
                 "FILE.<name>");
  app.add_option("--control", flags.control, "Unix socket for control (JSON-RPC)");
  app.add_option("--output", flags.output, "Folder for the files of the run");
  app.add_option("--plugin-dir", flags.plugin_dirs, "Folder searched for plugins first");
  app.add_option("--log-level", flags.log_level, "Level: debug, info, warn, error or off");
  app.add_option("--duration", flags.duration_s, "End after this much simulated time, s")
      ->check(CLI::PositiveNumber);
  app.add_flag("--ignore-missing", flags.ignore_missing,
               "Fly in an SDF world without the models and meshes that are nowhere to be found, as "
               "'missing: ignore' does");
  app.add_flag("--lockstep", flags.lockstep,
               "Wait for the controls that are due before each step, as 'pace: lockstep' does");
  app.add_flag("--paused", flags.paused, "Start paused at time zero");
  app.set_version_flag("--version", "hilsim " CAS_VERSION);
  base::cli::add_manual(app, "hilsim", CAS_VERSION);
}

/// Gives each interface plugin its `ledger` parameter, as if the file had it.
void order_ledgers(sim::SimConfig& config, const std::filesystem::path& file) {
  for (sim::VehicleConfig& vehicle : config.vehicles) {
    for (sim::PluginConfig& plugin : vehicle.plugins) {
      if (plugin.plugin != "mavlink_interface") continue;
      const std::string name =
          file.string() + (config.vehicles.size() > 1 ? "." + vehicle.name : "");
      const nlohmann::json quoted = name;
      plugin.params = base::ConfigNode::parse("ledger: " + quoted.dump(), "--ledger")
                          .merged_over(plugin.params);
    }
  }
}

/// A vehicle file, or the name of a shipped one.
std::filesystem::path vehicle_file(const std::string& word) {
  const bool name = word.find('/') == std::string::npos && word.find('.') == std::string::npos;
  return base::find_config(name ? "vehicles/" + word + ".yaml" : word);
}

/// Measures the vehicle in the wind tunnel. @throws base::ConfigError
void write_polar(const base::Vehicle& vehicle, const Flags& flags) {
  if (!vehicle.aero) {
    throw base::ConfigError("--polar: vehicle '" + vehicle.name + "' has no block 'aero'");
  }
  const auto angles = [](const std::vector<double>& values, const char* flag, double limit_deg) {
    return sim::AngleSweep{values[0], values[1], values[2]}.angles_deg(flag, limit_deg);
  };
  base::write_file(
      *flags.polar,
      sim::polar_csv(*vehicle.aero, flags.airspeed_m_s.value_or(vehicle.aero->cruise_m_s),
                     angles(flags.alpha, "--alpha", 180), angles(flags.beta, "--beta", 90)));
}

int describe(const Flags& flags) {
  const base::Vehicle vehicle = base::Vehicle::load(vehicle_file(*flags.describe));
  const sim::VehicleModel model = sim::load_vehicle_model(vehicle.urdf, vehicle.parts);
  std::string text =
      describe_vehicle(vehicle, model, base::load_frames(base::shipped_config("frames.yaml")));
  if (sim::hovers(vehicle)) {
    fcu::ControlParams gains;
    fcu::derive_gains(vehicle, fcu::kUsualDelay_s, gains);
    text += fcu::loop_table(fcu::rate_loops(vehicle, gains, fcu::kUsualDelay_s));
  }
  for (const auto& warnings : {vehicle.warnings, model.warnings, implausible(vehicle, model)}) {
    for (const std::string& warning : warnings) base::log::warn(warning);
  }
  std::fputs(text.c_str(), stdout);
  if (flags.svg) base::write_file(*flags.svg, draw_vehicle(vehicle, model));
  if (flags.polar) write_polar(vehicle, flags);
  return base::kExitOk;
}

/// The folders of all that the command line lets hilsim write.
std::vector<std::filesystem::path> output_folders(const Flags& flags) {
  std::vector<std::filesystem::path> folders{flags.output};
  for (const std::optional<std::filesystem::path>& file : {flags.stats, flags.control}) {
    if (!file) continue;
    const std::filesystem::path named = std::filesystem::absolute(*file);
    std::error_code error;
    folders.push_back(named.parent_path());
    folders.push_back(std::filesystem::weakly_canonical(named, error).parent_path());
  }
  return folders;
}

/// From here on hilsim and its plugins write below the folders of its results only, and to serial
/// lines that the simulation names.
/// @return false where the kernel cannot confine them
bool confine_writes(const Flags& flags, const sim::SimConfig& config) {
  std::vector<std::filesystem::path> places = output_folders(flags);
  for (const char* device :
       {"/dev/null", "/dev/tty", "/dev/pts", base::CpuLatencyRequest::kDevice}) {
    places.emplace_back(device);
  }
  for (const std::filesystem::path& line : sim::serial_places(config)) places.push_back(line);
  return base::confine_files(base::FileUse::kWrite, places);
}

/// From here on they read there only, and what they write.
void confine_reads(const Flags& flags, std::vector<std::filesystem::path> places) {
  for (const std::filesystem::path& folder : output_folders(flags)) places.push_back(folder);
  base::confine_files(base::FileUse::kRead, places);
}

sim::SimConfig load_config(const Flags& flags, const std::filesystem::path& file) {
  sim::SimConfig config = sim::SimConfig::load(file);
  if (flags.lockstep) config.pace.mode = sim::PaceMode::kLockstep;
  if (flags.ignore_missing) config.world.missing = sim::Missing::kIgnore;
  if (flags.ledger) order_ledgers(config, *flags.ledger);
  return config;
}

/// Priority, memory, wake-ups and name of the thread that steps.
void configure_loop_thread(const base::ThreadOptions& thread) {
  if (thread.fifo_priority) base::lock_memory();
  base::configure_this_thread("hilsim", thread);   // of the main thread: the name of the process
  ::prctl(PR_SET_TIMERSLACK, 1UL, 0UL, 0UL, 0UL);  // wake at the deadline, not up to 50 us later
}

void say_ready(const sim::SimRunner& runner, bool confined) {
  base::notify("READY=1\nSTATUS=" + sim::endpoints_report(runner));
  base::log::info(confined ? "running"
                           : "running; this kernel has no Landlock, so that plugins may read and "
                             "write whatever this user may");
}

/// Steps until the end. @return the error that ended it; recordings are still to be written
std::exception_ptr run_loop(sim::SimLoop& loop, const std::optional<double>& duration_s) {
  std::optional<base::SimTime> until;
  if (duration_s) until = base::SimTime(base::from_seconds(*duration_s));
  try {
    loop.run(until);
  } catch (const sim::LeftWorldError&) {
    return std::current_exception();
  } catch (const std::bad_alloc&) {
    return std::current_exception();
  }
  return nullptr;
}

void say_stopped(const sim::LoopFigures& figures) {
  base::log::info(fmt::format("stopped at {:.3f} s: {:.2f} x real time, {} late steps",
                              base::to_seconds(figures.time), figures.real_time_factor,
                              figures.late_steps));
}

int run(const Flags& flags) {
  if (flags.describe) return describe(flags);
  if (flags.config.empty()) {
    throw base::ConfigError(
        "config is required: the simulation to run (YAML), or --describe VEHICLE");
  }
  const std::filesystem::path file = base::find_config(flags.config);
  sim::SimConfig config = load_config(flags, file);
  base::make_out_folder(flags.output);

  const bool confined = confine_writes(flags, config);
  sim::SimRunner runner(std::move(config),
                        {.output_dir = flags.output, .plugin_dirs = flags.plugin_dirs});
  confine_reads(flags, sim::readable_places(runner, file, flags.plugin_dirs));
  const sim::PaceConfig pace = runner.config().pace;
  sim::SimLoop loop(runner, pace);
  const auto control = base::bind_command_port(
      [&] { return std::make_unique<sim::ControlServer>(loop, flags.control); });
  runner.start();
  const base::CpuLatencyRequest latency(pace.cpu_dma_latency_us);
  configure_loop_thread(pace.thread);
  if (flags.paused) loop.post([&loop] { loop.pause(); });

  say_ready(runner, confined);
  const std::exception_ptr trouble = run_loop(loop, flags.duration_s);

  base::notify("STOPPING=1");
  runner.finish();
  if (flags.stats) sim::write_report(*flags.stats, sim::stats_report(loop));
  say_stopped(loop.figures());
  if (trouble) std::rethrow_exception(trouble);
  return base::kExitOk;
}

}  // namespace

int main(int argc, char** argv) try {
  CLI::App app("Simulates vehicles and their sensors for hardware-in-the-loop flight.", "hilsim");
  Flags flags;
  add_flags(app, flags);
  if (const auto ended = base::cli::parse(app, argc, argv, base::kExitConfig)) return *ended;
  return base::run_program("hilsim", flags.log_level, [&] { return run(flags); });
} catch (const std::exception& error) {  // no memory to read the command line
  std::fprintf(stderr, "hilsim: internal error: %s\n", error.what());
  return base::kExitInternal;
}
