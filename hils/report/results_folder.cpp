// SPDX-License-Identifier: BSD-3-Clause
#include "hils/report/results_folder.hpp"

#include <fmt/format.h>
#include <fnmatch.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <filesystem>
#include <functional>
#include <system_error>
#include <vector>

#include "base/error.hpp"
#include "base/os/result_file.hpp"
#include "hils/report/junit_report.hpp"
#include "hils/report/plot.hpp"
#include "hils/report/run_plots.hpp"
#include "hils/report/run_report.hpp"
#include "hils/report/summary_json.hpp"
#include "hils/run/run_paths.hpp"

namespace cas::hils {

namespace {

namespace fs = std::filesystem;

/// What a program for continuous integration or a person would take for the verdict of this run.
constexpr std::array kVerdict{"summary.json", "junit.xml",   "report.html",
                              "replay.html",  "boards.json", "board.ulg"};
/// Every run writes it first: the folder holds a run.
constexpr const char* kRunMark = "run/hilsim.yaml";
/// The other files and folders of a run, as fnmatch(3) has them.
constexpr std::array kRecords{
    "plugin_figures.json", "truth.csv",   "truth_*.csv",       "flight.tlog",     "flight.ulg",
    "flight_*.ulg",        "flight.mcap", "sensors/*.csv",     "sensors_*/*.csv", "plots/*.svg",
    "plots/*/*.svg",       "*/board.ulg", "run/*.yaml",        "run/*.csv",       "run/*.json",
    "run/*.json.gz",       "run/*.log",   "run/flight_*.tlog", "run/firmware",    "run/firmware_*",
    "run/scenario"};

/// The records below a folder of results, by their paths from there. No symlink is followed.
std::vector<fs::path> left_by_run(const fs::path& folder) {
  constexpr int kDeepest = 2;  // plots/VEHICLE/track.svg
  std::vector<fs::path> left;
  fs::recursive_directory_iterator entry(folder, fs::directory_options::skip_permission_denied);
  for (; entry != fs::recursive_directory_iterator(); ++entry) {
    const fs::path path = entry->path().lexically_relative(folder);
    const auto fits = [&path](const char* pattern) {
      return ::fnmatch(pattern, path.c_str(), FNM_PATHNAME | FNM_PERIOD) == 0;
    };
    const bool is_left = path != kRunMark && std::ranges::any_of(kRecords, fits);
    if (is_left) left.push_back(path);
    if (is_left || entry.depth() == kDeepest) entry.disable_recursion_pending();
  }
  return left;
}

void write_plots(const std::filesystem::path& out, const std::filesystem::path& folder,
                 const NamedPlots& plots) {
  for (const auto& [name, plot] : plots) {
    base::write_result({out, folder / (name + ".svg")}, to_svg(plot));
  }
}

/// The scenario, its vehicle files and the configurations generated from them; each file once.
std::vector<std::filesystem::path> quoted_files(const RunRequest& request) {
  const RunPaths paths = RunPaths::of(request.scenario, request.out, request.out / "run");
  std::vector<std::filesystem::path> files{request.scenario.file};
  for (const ScenarioVehicle& vehicle : request.scenario.vehicles) {
    if (std::ranges::find(files, vehicle.vehicle) == files.end()) files.push_back(vehicle.vehicle);
  }
  files.push_back(paths.simulator_config());
  files.push_back(paths.casd_config());
  if (request.scenario.firmware) return files;
  for (const VehiclePaths& vehicle : paths.vehicles) files.push_back(vehicle.fcu_config());
  return files;
}

/// Whether everybody may lay symlinks and files in a folder of another user.
bool is_open_to_all(const fs::path& folder) {
  struct stat status {};
  if (::stat(folder.c_str(), &status) != 0) return false;
  const bool is_own = status.st_uid == 0 || status.st_uid == ::geteuid();
  return !is_own && (status.st_mode & S_IWOTH) != 0;
}

}  // namespace

void make_results_folder(const fs::path& folder) {
  const auto refuse = [&folder](const std::string& why) {
    throw base::ConfigError("--out: " + folder.string() + why);
  };
  if (is_open_to_all(folder)) {
    refuse(" is a folder of another user that everybody may write into; give one of your own");
  }
  try {
    base::make_out_folder(folder);
  } catch (const base::ConfigError& error) {
    throw base::ConfigError(std::string("--out: ") + error.what());
  }
  if (::access(folder.c_str(), W_OK | X_OK) != 0) {
    refuse(" cannot be written to: " + base::error_text(errno));
  }
}

fs::path make_next_folder(const fs::path& parent, const std::string& name) {
  make_results_folder(parent);
  for (int number = 1;; ++number) {
    const fs::path folder = parent / (number == 1 ? name : fmt::format("{}-{}", name, number));
    if (::mkdir(folder.c_str(), 0777) == 0) return folder;
    if (errno != EEXIST) {
      throw base::ConfigError(folder.string() + " cannot be created: " + base::error_text(errno));
    }
  }
}

void clear_earlier_run(const fs::path& folder) {
  for (const char* const name : kVerdict) {
    // A folder of that name is no page of an earlier run; writing the page reports it.
    const bool page = fs::path(name).extension() == ".html";
    if (page && fs::is_directory(folder / name)) continue;
    base::remove_result({folder, name});
  }
  std::error_code none;
  if (!fs::exists(fs::symlink_status(folder / kRunMark, none))) return;
  std::vector<fs::path> folders;
  for (const fs::path& left : left_by_run(folder)) {
    if (fs::is_directory(fs::symlink_status(folder / left))) {
      fs::remove_all(folder / left, none);
    } else {
      base::remove_result({folder, left});
    }
    for (fs::path above = left.parent_path(); !above.empty(); above = above.parent_path()) {
      folders.push_back(above);
    }
  }
  base::remove_result({folder, kRunMark});  // last: a clearing that broke off is taken up again
  folders.emplace_back("run");
  std::ranges::sort(folders, std::greater<>());  // a folder behind those in it
  for (const fs::path& empty : folders) ::rmdir((folder / empty).c_str());  // keeps what is not
}

void write_results(const RunRequest& request, const RunResult& run) {
  const std::filesystem::path& out = request.out;
  base::write_result({out, "summary.json"}, summary_json(run));
  base::write_result({out, "junit.xml"}, junit_report(run));
  std::vector<NamedPlots> plots;
  for (const VehicleResult& vehicle : run.vehicles) {
    plots.push_back(run_plots(vehicle.record, vehicle.figures));
    const std::filesystem::path folder = "plots";
    write_plots(out, run.has_several() ? folder / vehicle.figures.vehicle : folder, plots.back());
  }
  base::write_result({out, "report.html"},
                     write_html(run_report(run, {.beside_paper = request.beside_paper,
                                                 .plots = plots,
                                                 .config_files = quoted_files(request)})));
}

}  // namespace cas::hils
