// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "hils/measure/run_result.hpp"
#include "hils/run/run_request.hpp"

namespace CLI {
class App;
}

namespace cas::hils {

/// Leaves the record of a run in its folder, and replay.html where the page was built; one of an
/// earlier run goes in any case.
/// @return replay.html, or an empty path
/// @throws base::ConfigError
std::filesystem::path write_replay(const RunRequest& request, const RunResult& run);
/// The same with a record that is there already. @param record  JSON
std::filesystem::path write_replay(const std::filesystem::path& out, const std::string& record);

/// The verb `hils replay`: makes the page of recorded runs and flight logs.
class ReplayCommand {
 public:
  explicit ReplayCommand(CLI::App& app);
  bool parsed() const;
  /// @return exit code 0 @throws base::ConfigError
  int run() const;

 private:
  const CLI::App* command_;
  std::vector<std::string> sources_;
  std::string out_;
};

}  // namespace cas::hils
