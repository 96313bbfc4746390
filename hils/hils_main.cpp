// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <signal.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "base/cli/manual.hpp"
#include "base/cli/parse.hpp"
#include "base/cli/verb.hpp"
#include "base/error.hpp"
#include "base/os/log.hpp"
#include "base/printable.hpp"
#include "hils/boards/board_command.hpp"
#include "hils/boards/board_error.hpp"
#include "hils/boards/board_flags.hpp"
#include "hils/measure/judgement.hpp"
#include "hils/programs/supervisor.hpp"
#include "hils/run/verbs.hpp"
#include "hils/run_command.hpp"

namespace {

using namespace cas;
using namespace cas::hils;

/// A sentence may quote a file: nothing in it reaches the terminal but its letters.
void tell(const std::exception& error) {
  fmt::print(stderr, "hils: {}\n", base::printable_lines(error.what()));
}

/// Runs a command and turns its exception into a sentence and an exit code.
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

}  // namespace

int main(int argc, char** argv) try {
  CLI::App app("Flies experiments with a controller in the loop, measures and judges them", "hils");
  app.set_version_flag("--version", "hils " + std::string(CAS_VERSION));
  app.require_subcommand(1);
  std::string log_level = "warn";
  app.add_option("--log-level", log_level, "Level: debug, info, warn, error or off");

  const std::vector<base::cli::Verb> verbs{add_run(app),    add_compare(app), add_sweep(app),
                                           add_tune(app),   add_eval(app),    add_campaign(app),
                                           add_replay(app), add_explain(app), add_runs(app),
                                           add_timing(app), add_board(app)};
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
    return base::cli::find_asked(verbs)->run();
  });
} catch (const std::exception& error) {  // no memory for the command line
  std::fprintf(stderr, "hils: %s\n", error.what());
  return kExitInvalid;
}
