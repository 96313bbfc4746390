// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "base/error.hpp"
#include "hils/run/verbs.hpp"
#include "hils/runs/run_folder.hpp"
#include "hils/runs/run_story.hpp"

namespace cas::hils {

namespace {

int explain(const std::filesystem::path& folder) {
  const nlohmann::json summary = read_summary(folder);
  try {
    fmt::print("{}", story_text(run_story(summary, read_record(folder))));
  } catch (const base::ConfigError& error) {
    throw base::ConfigError(folder.string() + ": " + error.what());
  }
  return 0;
}

}  // namespace

base::cli::Verb add_explain(CLI::App& app) {
  const auto folder = std::make_shared<std::string>();
  CLI::App* command = app.add_subcommand(
      "explain", "Tell how a finished run went, and why it failed, from its folder of results");
  command->add_option("OUT", *folder, "Folder of results of a run")->required();
  return {command, [folder] { return explain(*folder); }};
}

}  // namespace cas::hils
