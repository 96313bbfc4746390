// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "hils/sweep/sweep_folder.hpp"

namespace cas::hils {

/// Writes the scenario of a row into its folder of again/. @throws base::ConfigError
void write_row_again(const SweepFolder& sweep, std::size_t row);

/// The words of the command that flies a row once more, after its scenario has been written.
std::vector<std::string> command_again(const SweepFolder& sweep, std::size_t row);

/// Flies rows once more by `hils run`, each with a whole report and its replay; those that have one
/// are left as they are. @param jobs  at once @return rows that have a report now
std::vector<std::size_t> fly_again(const SweepFolder& sweep, const std::vector<std::size_t>& rows,
                                   std::size_t jobs);

/// Whether the flight of a row in again/ differs from the one in the journal: its true motion is
/// not the same to the byte. @param result  of the row, in a scenario of one vehicle
bool flew_otherwise(const SweepFolder& sweep, const RowResult& result);

}  // namespace cas::hils
