// SPDX-License-Identifier: BSD-3-Clause
#include "hils/runs/run_list.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "base/error.hpp"
#include "hils/replay/run_settings.hpp"
#include "hils/report/document.hpp"
#include "hils/report/number_text.hpp"
#include "hils/runs/run_folder.hpp"

namespace cas::hils {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

constexpr int kDeepest = 8;              // folders below the searched one
constexpr std::size_t kMostRuns = 5000;  // a page of them still opens at once

/// Numbers below an object; lists are left out.
void add_numbers(const std::string& path, const Json& value,
                 std::map<std::string, double>& figures) {
  if (value.is_number()) figures[path] = value.get<double>();
  if (!value.is_object()) return;
  for (const auto& [key, inner] : value.items()) {
    add_numbers(path.empty() ? key : path + "." + key, inner, figures);
  }
}

std::string verdict_of(const Json& summary) {
  if (!summary.value("valid", false)) return "INVALID";
  return summary.value("passed", false) ? "PASSED" : "FAILED";
}

ListedRun read_run(const fs::path& folder, const fs::path& top) {
  const Json summary = read_summary(folder);
  ListedRun run{.folder = folder.lexically_relative(top).string(),
                .verdict = verdict_of(summary),
                .scenario = summary.at("scenario").get<std::string>(),
                .architecture = summary.value("architecture", std::string()),
                .clock = summary.value("virtual_clock", false) ? "virtual"
                         : summary.value("lockstep", false)    ? "lockstep"
                                                               : "real time",
                .seed = summary.value("seed", std::uint64_t{0}),
                .ended_s = end_of_run(folder),
                .settings = run_settings(folder)};
  for (const auto& [key, value] : summary.items()) {
    if (key != "schema" && key != "seed") add_numbers(key, value, run.figures);
  }
  const Json& vehicles = summary["vehicles"];
  for (const Json& vehicle : vehicles) {
    const auto name = vehicle.at("name").get<std::string>();
    add_numbers(vehicles.size() > 1 ? name : "", vehicle, run.figures);
    if (vehicle.contains("autopilot")) {
      run.controller =
          vehicle["autopilot"].get<std::string>() + " " + vehicle.value("firmware", std::string());
    }
  }
  if (!summary.at("failures").empty()) run.why = summary["failures"][0].get<std::string>();
  return run;
}

std::string local_time(std::int64_t seconds) {
  return fmt::format("{:%Y-%m-%d %H:%M}", fmt::localtime(static_cast<std::time_t>(seconds)));
}

}  // namespace

std::optional<double> ListedRun::figure(const std::string& path) const {
  const auto found = figures.find(path);
  return found == figures.end() ? std::nullopt : std::optional(found->second);
}

RunList find_runs(const fs::path& folder) {
  if (!fs::is_directory(folder)) throw base::ConfigError(folder.string() + ": no such folder");
  RunList list;
  const auto look = [&](const fs::path& where) {
    if (!is_run_folder(where) || list.runs.size() == kMostRuns) return;
    try {
      list.runs.push_back(read_run(where, folder));
    } catch (const Json::exception&) {
      list.unread.push_back(where.string() + ": its summary is not as hils writes it");
    } catch (const std::exception& error) {
      list.unread.emplace_back(error.what());
    }
  };
  look(folder);
  constexpr auto kSkip = fs::directory_options::skip_permission_denied;
  std::error_code error;
  for (fs::recursive_directory_iterator entry(folder, kSkip, error), end; entry != end;
       entry.increment(error)) {
    if (error) break;
    if (!entry->is_directory(error) || entry->is_symlink(error)) continue;
    if (entry.depth() == kDeepest) entry.disable_recursion_pending();
    look(entry->path());
  }
  std::ranges::stable_sort(list.runs, [](const ListedRun& a, const ListedRun& b) {
    return a.ended_s != b.ended_s ? a.ended_s > b.ended_s : a.folder < b.folder;
  });
  return list;
}

std::string run_table(const std::vector<ListedRun>& runs) {
  Rows rows{{"VERDICT", "SCENARIO", "ENDED", "SEED", "CLOCK", "RMS m", "FOLDER", "WHY"}};
  for (const ListedRun& run : runs) {
    rows.push_back({run.verdict, run.scenario, local_time(run.ended_s), std::to_string(run.seed),
                    run.clock, fixed(run.figure("rms_position_m"), 3), run.folder, run.why});
  }
  return aligned_table(rows, Align::kLeft);
}

}  // namespace cas::hils
