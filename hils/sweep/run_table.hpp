// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "hils/sweep/study.hpp"

namespace cas::hils {

/// One run of a sweep.
struct TableRow {
  std::size_t row = 0;    ///< from 1
  std::size_t point = 0;  ///< from 1: rows of one point differ in their seed alone
  std::uint64_t seed = 1;
  std::vector<std::string> values{};  ///< in the order of the parameters, as the scenario gets them
};

/// All runs of a sweep.
struct RunTable {
  std::vector<std::string> names{};  ///< of the parameters
  std::vector<TableRow> rows{};      ///< row i is rows[i - 1]

  /// Each combination of the parameters with values (the last one changes first), each of its
  /// points of the others, each seed.
  /// @param scenario_seed  where the study names no seeds
  /// @throws base::ConfigError when there are more than 10 million rows
  static RunTable of(const Study& study, std::uint64_t scenario_seed);
  /// Reads a table of csv(). @param name  for errors @throws base::ConfigError
  static RunTable parse(std::string_view text, const std::string& name);
  /// "row,point,seed,NAME,..." and a line for each row.
  std::string csv() const;
};

/// The rows of chunk `k` of `n`: [first, last), counted from 1. Chunks differ by at most one row.
std::pair<std::size_t, std::size_t> rows_of_chunk(std::size_t rows, std::size_t k, std::size_t n);

/// A number of a table: nine digits, so that the last bits of a machine's mathematics library do
/// not show.
std::string value_text(double value);

/// A field of a CSV file, in quotes where it needs them.
std::string csv_field(std::string_view text);
/// The fields of one line. @return empty where quotes do not close
std::vector<std::string> csv_fields(std::string_view line);

}  // namespace cas::hils
