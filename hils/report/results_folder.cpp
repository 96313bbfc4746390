// SPDX-License-Identifier: BSD-3-Clause
#include "hils/report/results_folder.hpp"

#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <system_error>
#include <vector>

#include "base/error.hpp"
#include "base/os/result_file.hpp"
#include "hils/report/html_report.hpp"
#include "hils/report/junit_report.hpp"
#include "hils/report/plot.hpp"
#include "hils/report/run_plots.hpp"
#include "hils/report/summary_json.hpp"
#include "hils/run/run_places.hpp"

namespace cas::hils {

namespace {

void write_plots(const std::filesystem::path& out, const std::filesystem::path& folder,
                 const NamedPlots& plots) {
  for (const auto& [name, plot] : plots) {
    base::write_result({out, folder / (name + ".svg")}, to_svg(plot));
  }
}

/// The scenario, its vehicle files and the configurations generated from them; each file once.
std::vector<std::filesystem::path> quoted_files(const RunRequest& request) {
  const RunPlaces places = RunPlaces::of(request.scenario, request.out, request.out / "run");
  std::vector<std::filesystem::path> files{request.scenario.file};
  for (const ScenarioVehicle& vehicle : request.scenario.vehicles) {
    if (std::ranges::find(files, vehicle.vehicle) == files.end()) files.push_back(vehicle.vehicle);
  }
  files.push_back(places.simulator_config());
  files.push_back(places.casd_config());
  for (const VehiclePlaces& vehicle : places.vehicles) files.push_back(vehicle.fcu_config());
  return files;
}

/// Whether only somebody else says what this name stands for.
bool is_anothers(const struct stat& status) {
  if (status.st_uid == 0 || status.st_uid == ::geteuid()) return false;
  return S_ISLNK(status.st_mode) || (status.st_mode & S_IWOTH) != 0;
}

/// A symlink or a folder of another user may lead the results into files of this one.
void refuse_anothers(const std::filesystem::path& folder) {
  const auto name = folder.has_filename() ? folder : folder.parent_path();  // "out/" as "out"
  struct stat link {};
  struct stat target {};
  if (::lstat(name.c_str(), &link) != 0) return;
  if (is_anothers(link) || (::stat(name.c_str(), &target) == 0 && is_anothers(target))) {
    throw base::ConfigError("--out: " + folder.string() + " is " +
                            (S_ISLNK(link.st_mode) && is_anothers(link)
                                 ? "a symlink of another user"
                                 : "a folder of another user that everybody may write into") +
                            "; give one of your own");
  }
}

}  // namespace

void make_results_folder(const std::filesystem::path& folder) {
  const auto refuse = [&folder](const char* what, const std::error_code& why) {
    throw base::ConfigError("--out: " + folder.string() + " cannot be " + what + ": " +
                            why.message());
  };
  refuse_anothers(folder);
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) refuse("created", error);
  if (::access(folder.c_str(), W_OK | X_OK) != 0) {
    refuse("written to", {errno, std::generic_category()});
  }
}

void remove_verdict(const std::filesystem::path& folder) {
  for (const char* name : {"summary.json", "junit.xml", "report.html", "replay.html",
                           "run/hilsim_stats.json", "boards.json", "board.ulg"}) {
    // A folder of that name is no page of an earlier run; writing the page reports it.
    const bool page = std::filesystem::path(name).extension() == ".html";
    if (page && std::filesystem::is_directory(folder / name)) continue;
    base::remove_result({folder, name});
  }
}

void write_results(const RunRequest& request, const RunResult& run) {
  const std::filesystem::path& out = request.out;
  base::write_result({out, "summary.json"}, summary_json(run));
  base::write_result({out, "junit.xml"}, junit_report(run));
  std::vector<NamedPlots> plots;
  for (const VehicleResult& vehicle : run.vehicles) {
    plots.push_back(run_plots(request.scenario, vehicle.record, vehicle.figures));
    const std::filesystem::path folder = "plots";
    write_plots(out, run.has_several() ? folder / vehicle.figures.vehicle : folder, plots.back());
  }
  base::write_result({out, "report.html"}, html_report(run, plots, quoted_files(request)));
}

}  // namespace cas::hils
