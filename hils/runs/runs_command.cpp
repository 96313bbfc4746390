// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <string>

#include "base/os/result_file.hpp"
#include "base/printable.hpp"
#include "hils/run/verbs.hpp"
#include "hils/runs/run_list.hpp"
#include "hils/runs/runs_page.hpp"

namespace cas::hils {

namespace {

int list_runs(const std::filesystem::path& folder) {
  const RunList list = find_runs(folder);
  for (const std::string& sentence : list.unread) {
    fmt::print(stderr, "hils: not read: {}\n", base::printable(sentence));
  }
  if (list.runs.empty()) {
    fmt::print("{}: no run of hils lies here or below\n", folder.string());
    return 0;
  }
  base::write_result({folder, "runs.html"},
                     runs_page(std::filesystem::absolute(folder).lexically_normal(), list));
  fmt::print("{}Page: {}\n", run_table(list.runs), (folder / "runs.html").string());
  return 0;
}

}  // namespace

base::cli::Verb add_runs(CLI::App& app) {
  const auto folder = std::make_shared<std::string>("out");
  CLI::App* command = app.add_subcommand(
      "runs", "List the finished runs below a folder, and write a page that compares any two");
  command->add_option("FOLDER", *folder, "Folder that is searched (out); runs.html goes there");
  return {command, [folder] { return list_runs(*folder); }};
}

}  // namespace cas::hils
