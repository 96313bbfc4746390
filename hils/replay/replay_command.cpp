// SPDX-License-Identifier: BSD-3-Clause
#include "hils/replay/replay_command.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <vector>

#include "base/error.hpp"
#include "base/os/result_file.hpp"
#include "base/os/write_file.hpp"
#include "base/read_file.hpp"
#include "hils/replay/replay_page.hpp"
#include "hils/replay/replay_record.hpp"
#include "hils/run/verbs.hpp"

namespace cas::hils {

namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMaxRecordBytes = std::size_t{256} << 20U;  // gzipped

/// The gzipped record of a run's folder or of a flight log.
std::string record_of(const fs::path& source) {
  if (source.extension() == ".tlog") return gzip(tlog_record(source));
  if (source.extension() == ".ulg") return gzip(ulog_record(source));
  if (source.extension() == ".mcap") return gzip(mcap_record(source));
  if (!fs::is_directory(source)) {
    throw base::ConfigError(source.string() +
                            ": neither the folder of a run nor a flight log (.tlog, .ulg, .mcap)");
  }
  const fs::path file = record_file(source);
  if (!fs::exists(file)) {
    throw base::ConfigError(source.string() + ": has no record (" +
                            file.lexically_relative(source).string() +
                            "); `hils run` leaves one in its --out folder");
  }
  std::string record = base::read_foreign_file(file, "record", kMaxRecordBytes);
  check_gzip(record);  // says so when it is cut
  return record;
}

struct Flags {
  std::vector<std::string> sources;
  std::string out;
};

int run(const Flags& flags) {
  fs::path out = flags.out;
  if (out.empty()) {
    if (flags.sources.size() == 1 && !fs::exists(flags.sources.front())) {
      throw base::ConfigError(flags.sources.front() + ": no such file or folder");
    }
    if (flags.sources.size() != 1 || !fs::is_directory(flags.sources.front())) {
      throw base::ConfigError("--out FILE is needed, unless one folder of a run is replayed");
    }
    out = fs::path(flags.sources.front()) / "replay.html";
  }
  std::vector<std::string> records;
  std::vector<fs::path> sources;  // two are told apart; one may have any name
  if (flags.sources.size() == 2) sources.assign(flags.sources.begin(), flags.sources.end());
  for (const std::string& source : flags.sources) records.push_back(record_of(source));
  base::write_file(out, replay_page(records, sources), base::Durability::kCache);
  fmt::print("Replay: {}\n", out.string());
  return 0;
}

}  // namespace

fs::path write_replay(const RunRequest& request, const RunResult& run) {
  return write_replay(request.out, replay_record(request, run));
}

fs::path write_replay(const fs::path& out, const std::string& text) {
  const std::string record = gzip(text);
  base::write_result({out, record_file(out)}, record);
  fs::path file = out / "replay.html";
  base::remove_result({out, file});  // of an earlier run
  if (!has_page()) return {};
  base::write_result({out, file}, replay_page({&record, 1}));
  return file;
}

base::cli::Verb add_replay(CLI::App& app) {
  const auto flags = std::make_shared<Flags>();
  CLI::App* command = app.add_subcommand(
      "replay", "Make a page that replays a run, or two side by side, without a server");
  command
      ->add_option("SOURCE", flags->sources,
                   "Folder of a run or a flight log (.tlog, .ulg, .mcap); a second one is shown "
                   "beside the first")
      ->required()
      ->expected(1, 2);
  command->add_option("--out", flags->out, "File for the page (of one folder: its replay.html)");
  return {command, [flags] { return run(*flags); }};
}

}  // namespace cas::hils
