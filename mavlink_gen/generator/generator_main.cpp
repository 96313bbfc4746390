// SPDX-License-Identifier: BSD-3-Clause
#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "mavlink_gen/generator/cpp_writer.hpp"
#include "mavlink_gen/generator/naming.hpp"
#include "mavlink_gen/parser/dialect_loader.hpp"

namespace {

using namespace cas::mav;

enum ExitCode : int { kDone = 0, kInputErrors = 1, kUsage = 2, kCannotWrite = 3 };

struct GenerateOptions {
  std::vector<std::string> files;
  std::string out;
  std::string stamp;
};

std::optional<xml::Dialect> load(const std::string& file) {
  xml::Diagnostics diagnostics;
  auto dialect = xml::load_dialect(file, diagnostics);
  std::fputs(diagnostics.render().c_str(), stderr);
  return dialect;
}

int write(const std::filesystem::path& folder, const gen::Files& files) {
  const auto problem = gen::write_files(folder, files);
  if (problem.empty()) return kDone;
  std::fprintf(stderr, "mavlink_gen: %s\n", problem.c_str());
  return kCannotWrite;
}

int generate(const GenerateOptions& options) {
  gen::Files files;
  for (const auto& file : options.files) {
    const auto dialect = load(file);
    if (!dialect) return kInputErrors;
    files.merge(gen::write_cpp(*dialect, gen::safe_identifier(gen::lower_case(dialect->name))));
  }
  const auto code = write(options.out, files);
  if (code == kDone && !options.stamp.empty()) std::ofstream(options.stamp).put('\n');
  return code;
}

}  // namespace

int main(int argc, char** argv) try {
  CLI::App app("Turns MAVLink dialects (XML) into C++20 headers");
  app.require_subcommand(1);
  GenerateOptions options;
  auto* generate_command = app.add_subcommand("generate", "Write C++ headers");
  generate_command->add_option("--out", options.out, "Folder that gets mavlink/<dialect>/")
      ->required();
  generate_command->add_option("--stamp", options.stamp,
                               "File that is touched when all is written");
  generate_command->add_option("files", options.files, "Dialect files")->required();
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? kDone : kUsage;
  }
  return generate(options);
} catch (const std::exception& error) {
  std::fprintf(stderr, "mavlink_gen: %s\n", error.what());
  return kCannotWrite;
}
