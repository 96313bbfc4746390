// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "hils/sweep/row_result.hpp"
#include "hils/sweep/study.hpp"

namespace cas::hils {

/// Schema of the lines of `hils eval`, printed by --describe.
inline constexpr int kEvalSchema = 1;

/// One line that comes in: {"id": any, "parameters": {NAME: value, ...}, "seed": 1}.
struct EvalRequest {
  std::string id = "null";                                        ///< JSON, given back as it came
  std::vector<std::pair<std::string, std::string>> parameters{};  ///< name, YAML
  std::uint64_t seed = 1;
  std::optional<std::string> error{};  ///< why the line is no request; then only `id` is valid

  /// @param seed  where the line has none
  static EvalRequest parse(std::string_view line, const std::vector<Parameter>& parameters,
                           std::uint64_t seed);
};

/// {"id": ..., "outcome": "passed", "up": 1, "cause": "", "incident": "", "seed": 1, "figures":
/// {NAME: number or null}, "truth_sha256": "...", "wall_s": 0.5} and a line break.
std::string eval_answer(const EvalRequest& request, const RowResult& result,
                        const std::vector<std::string>& figures);
/// {"id": ..., "error": "..."} and a line break.
std::string eval_error(const EvalRequest& request, const std::string& sentence);
/// Description of requests and answers, on one line: {"schema": 1, "parameters": [{"name", "keys",
/// "values" or "least" and "most" with "log"}], "figures": [...]}.
std::string eval_description(const Study& study, const std::vector<std::string>& figures);

}  // namespace cas::hils
