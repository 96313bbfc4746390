// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/core/load/sdf_missing.hpp"

#include "base/config/model_uri.hpp"
#include "base/error.hpp"

namespace cas::sim {

namespace {

namespace fs = std::filesystem;

/// Names the reference to each missing file, and the places searched.
std::string sentence_of(const std::vector<MissingFile>& missing,
                        const std::vector<fs::path>& model_path) {
  std::string text = missing.front().place + ": ";
  for (const MissingFile& each : missing) {
    const bool first = &each == &missing.front();
    text += (first ? "" : ", ") + each.what + (first ? "" : " (" + each.place + ")");
  }
  text += missing.size() == 1 ? " is nowhere to be found" : " are nowhere to be found";
  text += missing.size() == 1 ? "; looked for it at " : "; looked for the first of them at ";
  return text + base::searched_places(missing.front().uri, missing.front().folder, model_path) +
         ". Name its folder in 'model_path' or GZ_SIM_RESOURCE_PATH; 'missing: ignore' "
         "(--ignore-missing) goes without it";
}

}  // namespace

void require_all(const std::vector<MissingFile>& missing, const WorldConfig& config,
                 const std::vector<fs::path>& model_path, WorldModel& model) {
  if (missing.empty()) return;
  if (config.missing == Missing::kError) throw base::ConfigError(sentence_of(missing, model_path));
  for (const MissingFile& each : missing) {
    model.warnings.push_back(each.place + ": " + each.what + " is nowhere to be found; left out");
  }
  if (model.statics.empty()) {
    throw base::ConfigError(config.sdf->string() + ": without " + missing.front().what +
                            " nothing is left that could carry a vehicle");
  }
}

}  // namespace cas::sim
