// SPDX-License-Identifier: BSD-3-Clause
#include "hils/runs/run_folder.hpp"

#include <sys/stat.h>

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "base/error.hpp"
#include "base/read_file.hpp"
#include "hils/replay/replay_page.hpp"

namespace cas::hils {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

constexpr std::size_t kMostSummaryBytes = std::size_t{64} << 20U;
constexpr std::size_t kMostRecordBytes = std::size_t{256} << 20U;  // gzipped

fs::path summary_file(const fs::path& folder) { return folder / "summary.json"; }

/// More than a run leaves: what another person has made need not end.
constexpr int kMostLevels = 64;
constexpr std::size_t kMostValues = 50'000'000;

Json parse(const fs::path& file, std::string_view text) {
  const auto bound = [&file, values = std::size_t{0}](int depth, auto, const Json&) mutable {
    if (depth > kMostLevels || ++values > kMostValues) {
      throw base::ConfigError(file.string() + ": has more levels or values than hils writes");
    }
    return true;
  };
  Json json = Json::parse(text, bound, false);
  if (!json.is_object()) throw base::ConfigError(file.string() + ": is not JSON as hils writes it");
  return json;
}

}  // namespace

bool is_run_folder(const fs::path& folder) {
  std::error_code none;
  return fs::is_regular_file(summary_file(folder), none);
}

Json read_summary(const fs::path& folder) {
  if (!fs::exists(folder)) throw base::ConfigError(folder.string() + ": no such folder");
  if (!is_run_folder(folder)) {
    throw base::ConfigError(folder.string() +
                            ": holds no run: it has no summary.json, which `hils run` leaves in "
                            "its folder of results");
  }
  const fs::path file = summary_file(folder);
  Json summary = parse(file, base::read_foreign_file(file, "summary", kMostSummaryBytes));
  if (!summary.contains("vehicles") || !summary["vehicles"].is_array()) {
    throw base::ConfigError(file.string() +
                            ": has no list of vehicles: no summary of a run, or of an older CAS");
  }
  return summary;
}

Json read_record(const fs::path& folder) {
  const fs::path file = record_file(folder);
  if (!fs::exists(file)) return nullptr;
  return parse(file, gunzip(base::read_foreign_file(file, "record", kMostRecordBytes)));
}

std::int64_t end_of_run(const fs::path& folder) {
  struct stat status {};
  return ::stat(summary_file(folder).c_str(), &status) == 0 ? status.st_mtime : 0;
}

}  // namespace cas::hils
