// SPDX-License-Identifier: BSD-3-Clause
#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <vector>

#include "base/cli/manual.hpp"
#include "base/cli/parse.hpp"
#include "base/printable.hpp"
#include "mavlink_gen/generator/diff.hpp"
#include "mavlink_gen/generator/naming.hpp"
#include "mavlink_gen/generator/output_files.hpp"
#include "mavlink_gen/generator/subset.hpp"
#include "mavlink_gen/generator/writers.hpp"
#include "mavlink_gen/parser/dialect_loader.hpp"

#ifndef CAS_VERSION
#define CAS_VERSION "unknown"
#endif

namespace {

using namespace cas::mav;

enum ExitCode : int { kDone = 0, kInputErrors = 1, kUsage = 2, kCannotWrite = 3, kBreaks = 4 };

constexpr const char* kExitCodes =
    "Exit codes: 0 done, 1 the input has errors, 2 wrong use, 3 cannot write, 4 diff: the change "
    "breaks the wire";

struct Options {
  std::vector<std::string> files;
  std::string out;
  std::string name;
  std::string stamp;
  std::vector<std::string> only;
  bool strict{};
  bool with_runtime{};
  bool single{};
};

int complain(const std::string& sentence, int code) {
  std::fprintf(stderr, "mavlink_gen: %s\n", cas::base::printable_lines(sentence).c_str());
  return code;
}

/// Loads a dialect and prints its diagnostics; nullopt if it has errors.
std::optional<xml::Dialect> load(const std::string& file, bool strict = false) {
  xml::Diagnostics diagnostics;
  auto dialect = xml::load_dialect(file, diagnostics);
  std::fputs(cas::base::printable_lines(diagnostics.render()).c_str(), stderr);
  if (strict && diagnostics.warning_count() > 0) return std::nullopt;
  return dialect;
}

int generate(const Options& options) {
  if (!options.name.empty() && options.files.size() > 1) {
    return complain("--name goes with one dialect file", kUsage);
  }
  gen::Files files;
  for (const auto& file : options.files) {
    auto dialect = load(file, options.strict);
    if (!dialect) return kInputErrors;
    if (!options.only.empty()) {
      const auto problem = gen::keep_only(*dialect, options.only);
      if (problem) return complain(*problem, kInputErrors);
    }
    const auto name = gen::namespace_of(options.name.empty() ? dialect->name : options.name);
    auto headers = gen::write_cpp(*dialect, name);
    if (options.single) {
      headers.insert(gen::runtime_files().begin(), gen::runtime_files().end());
      headers = {{"mavlink/" + name + ".hpp", gen::amalgamate(headers, name)}};
    }
    files.merge(headers);  // leaves those whose place is taken
    for (const auto& [place, text] : headers) {
      if (files.at(place) == text) continue;
      return complain(file + ": another dialect is '" + name +
                          "' already; generate one of them alone, with --name",
                      kUsage);
    }
  }
  if (options.with_runtime) {
    files.insert(gen::runtime_files().begin(), gen::runtime_files().end());
  }
  if (const auto problem = gen::write_files(options.out, files)) {
    return complain(*problem, kCannotWrite);
  }
  if (!options.stamp.empty() && !std::ofstream(options.stamp).put('\n')) {
    return complain("cannot write " + options.stamp, kCannotWrite);
  }
  return kDone;
}

int check(const Options& options) {
  int code = kDone;
  for (const auto& file : options.files) {
    const auto dialect = load(file, options.strict);
    if (!dialect) {
      code = kInputErrors;
    } else {
      std::printf("%s: %zu messages, %zu enums, no errors\n", file.c_str(),
                  dialect->messages.size(), dialect->enums.size());
    }
  }
  return code;
}

int diff(const std::string& before_file, const std::string& after_file) {
  const auto before = load(before_file);
  const auto after = load(after_file);
  if (!before || !after) return kInputErrors;
  const auto changes = gen::compare(*before, *after);
  std::fputs(cas::base::printable_lines(gen::render(changes)).c_str(), stdout);
  const bool breaks = !changes.empty() && changes.front().impact == gen::Impact::kBreaks;
  return breaks ? kBreaks : kDone;
}

/// Writes one text made of a dialect to --out or to the terminal.
int render(const Options& options, std::string (*write)(const xml::Dialect&)) {
  const auto dialect = load(options.files.front(), options.strict);
  if (!dialect) return kInputErrors;
  const auto text = write(*dialect);
  if (options.out.empty()) {
    const auto written = std::fwrite(text.data(), 1, text.size(), stdout);
    return written == text.size() && std::fflush(stdout) == 0 ? kDone : kCannotWrite;
  }
  const std::filesystem::path out(options.out);
  const auto problem = gen::write_files(out.parent_path(), {{out.filename().string(), text}});
  return problem ? complain(*problem, kCannotWrite) : kDone;
}

int run(int argc, char** argv) {
  CLI::App app("Turns MAVLink dialects (XML) into C++20 headers, and checks and compares them",
               "mavlink_gen");
  app.set_version_flag("--version", std::string("mavlink_gen " CAS_VERSION));
  app.footer(kExitCodes);
  app.require_subcommand(1);
  Options options;
  std::string before, after;

  auto* generate_command = app.add_subcommand("generate", "Write C++ headers");
  generate_command->add_option("files", options.files, "Dialect files")->required();
  generate_command->add_option("--out", options.out, "Folder that gets mavlink/<dialect>/")
      ->required();
  generate_command->add_option("--name", options.name, "Folder and namespace of the dialect");
  generate_command->add_option("--only", options.only, "Messages to keep: A,B,...")->delimiter(',');
  auto* with_runtime = generate_command->add_flag(
      "--with-runtime", options.with_runtime,
      "Write the runtime as well: the folder needs the standard library alone");
  generate_command
      ->add_flag(
          "--single", options.single,
          "Write one header for each dialect, mavlink/<dialect>.hpp, that holds all it needs")
      ->excludes(with_runtime);
  generate_command->add_option("--stamp", options.stamp, "File to touch when all is written");

  auto* check_command = app.add_subcommand("check", "Validate dialects, write nothing");
  check_command->add_option("files", options.files, "Dialect files")->required();

  auto* diff_command = app.add_subcommand("diff", "Say what a change of a dialect breaks");
  diff_command->add_option("old", before, "Dialect file before")->required();
  diff_command->add_option("new", after, "Dialect file after")->required();

  auto* docs_command = app.add_subcommand("docs", "Describe a dialect in Markdown");
  auto* json_command = app.add_subcommand("json", "Print all facts of a dialect as JSON");
  for (auto* command : {docs_command, json_command}) {
    command->add_option("file", options.files, "Dialect file")->required()->expected(1);
    command->add_option("--out", options.out, "File to write, else the terminal");
  }
  for (auto* command : {generate_command, check_command, docs_command, json_command}) {
    command->add_flag("--strict", options.strict, "Treat warnings as errors");
  }

  cas::base::cli::add_manual(app, "mavlink_gen", CAS_VERSION);
  if (const auto ended = cas::base::cli::parse(app, argc, argv, kUsage)) return *ended;
  if (*generate_command) return generate(options);
  if (*check_command) return check(options);
  if (*diff_command) return diff(before, after);
  return render(options, *docs_command ? gen::write_docs : gen::write_json);
}

}  // namespace

int main(int argc, char** argv) try {
  return run(argc, argv);
} catch (const std::exception& error) {
  return complain(error.what(), kCannotWrite);
}
