// SPDX-License-Identifier: BSD-3-Clause
#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>

#include "base/cli/keys_flag.hpp"
#include "base/cli/manual.hpp"
#include "base/cli/parse.hpp"
#include "base/config/install_paths.hpp"
#include "base/error.hpp"
#include "base/os/log.hpp"
#include "base/os/notify.hpp"
#include "base/os/program.hpp"
#include "base/os/runtime_folder.hpp"
#include "fcu/core/controller_description.hpp"
#include "fcu/core/fcu_config.hpp"
#include "fcu/emulator/emulator.hpp"

namespace {

using namespace cas;

struct Flags {
  std::filesystem::path config;
  std::string link = "${CAS_RUNTIME_DIR}/fcu0";
  fcu::EmulatorOptions options;
  std::string log_level = "info";
  bool lockstep = false;
  bool describe = false;
};

void add_flags(CLI::App& app, Flags& flags) {
  app.add_option("config", flags.config, "Flight controller to emulate (YAML)")->required();
  base::cli::add_keys_flag(app, fcu::controller_reference, "a controller file");
  app.add_option(
         "--link", flags.link,
         "Symlink to offer the pseudo-terminal under; ${NAME} is a variable of the environment")
      ->capture_default_str();
  app.add_option("--stats", flags.options.stats, "Write figures (JSON) to this file at the end");
  app.add_option("--ledger", flags.options.ledger, "Write the packet ledger (CSV) at the end");
  app.add_option("--control", flags.options.control, "Unix socket for control (JSON-RPC)");
  app.add_option("--params", flags.options.params,
                 "Parameter file: read at start, kept up to date");
  app.add_option("--files", flags.options.files,
                 "Folder to serve over MAVLink FTP as 'files', read only");
  app.add_flag("--lockstep", flags.lockstep,
               "Run every timer on the stream's time, as 'pace: lockstep' does");
  app.add_flag("--describe", flags.describe,
               "Print crossover, phase and gain margin of the rate loops with this vehicle, these "
               "parameters and this line, and end");
  app.add_option("--log-level", flags.log_level, "Level: debug, info, warn, error or off");
  app.set_version_flag("--version", "fcu_emulator " CAS_VERSION);
  base::cli::add_manual(app, "fcu_emulator", CAS_VERSION);
}

int run(Flags& flags) {
  fcu::FcuConfig config = fcu::FcuConfig::load(base::find_config(flags.config));
  if (flags.lockstep) config.pace = fcu::Pace::kLockstep;
  if (flags.describe) {
    std::fputs(fcu::describe_controller(config).c_str(), stdout);
    return base::kExitOk;
  }
  flags.options.link = base::expand_variables(flags.link);
  fcu::Emulator emulator(config, flags.options);
  base::log::info("running on " + emulator.endpoints());
  base::notify("READY=1\nSTATUS=" + emulator.endpoints());
  emulator.run();
  base::notify("STOPPING=1");
  base::log::info("stopped");
  return base::kExitOk;
}

}  // namespace

int main(int argc, char** argv) try {
  CLI::App app("Emulates a flight controller on a pseudo-terminal.", "fcu_emulator");
  Flags flags;
  add_flags(app, flags);
  if (const auto ended = base::cli::parse(app, argc, argv, base::kExitConfig)) return *ended;
  return base::run_program("fcu_emulator", flags.log_level, [&] { return run(flags); });
} catch (const std::exception& error) {  // no memory to read the command line
  std::fprintf(stderr, "fcu_emulator: internal error: %s\n", error.what());
  return base::kExitInternal;
}
