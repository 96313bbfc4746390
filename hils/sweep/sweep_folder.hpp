// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "hils/sweep/key_path.hpp"
#include "hils/sweep/row_result.hpp"
#include "hils/sweep/run_table.hpp"
#include "hils/sweep/study.hpp"

namespace cas::hils {

/// One part of a sweep: chunk k of n, from 1.
struct Chunk {
  std::size_t k = 1;
  std::size_t n = 1;

  /// Takes "2/3". @throws base::ConfigError
  static Chunk parse(const std::string& text);
  std::string name() const;  ///< "chunk_2_of_3"
};

/// The folder of a sweep: the study as planned, its table and the flown runs.
///
///   study.yaml, scenario.yaml, vehicle_*.yaml   frozen when it was planned
///   table.csv, plan.json                        the runs; the plan's identity
///   journal/chunk_K_of_N.jsonl                  a line for each run, on the disk before the next
///   chunks/chunk_K_of_N.csv                     a finished chunk; .machine.csv beside it
///   again/row_N/                                runs that were flown once more
struct SweepFolder {
  std::filesystem::path path;
  Study study;
  RunTable table;
  std::vector<std::string> figures;    ///< figure_names() of the scenario
  std::filesystem::path study_folder;  ///< values may name files in it

  /// Writes the table and all that a run needs; where the folder holds the same plan already,
  /// nothing is changed.
  /// @param files_from  values may name files in it; empty: in the folder of the study's file
  /// @throws base::ConfigError where it holds another one
  static SweepFolder plan(const std::filesystem::path& study_file,
                          const std::filesystem::path& folder,
                          const std::filesystem::path& files_from = {});
  /// Opens a planned folder. @throws base::ConfigError
  static SweepFolder open(const std::filesystem::path& folder);

  std::filesystem::path scenario() const { return path / "scenario.yaml"; }
  std::filesystem::path journal(const Chunk& chunk) const {
    return path / "journal" / (chunk.name() + ".jsonl");
  }
  std::filesystem::path chunk_csv(const Chunk& chunk) const {
    return path / "chunks" / (chunk.name() + ".csv");
  }
  std::filesystem::path machine_csv(const Chunk& chunk) const {
    return path / "chunks" / (chunk.name() + ".machine.csv");
  }
  std::filesystem::path again(std::size_t row) const {
    return path / "again" / ("row_" + std::to_string(row));
  }

  /// The keys that one row sets, in the order of the parameters.
  std::vector<KeyValue> values_of(const TableRow& row) const;
  /// Row `row`, from 1. @throws base::ConfigError when there is no such row
  const TableRow& row(std::size_t row) const;

  /// Calls `visit` for each line of each journal, in the order of their names and lines; torn lines
  /// are left out. A later line of a row replaces an earlier one, but a broken run's line does not
  /// replace a sound one's.
  void for_each_result(const std::function<void(RowResult&&)>& visit) const;
  /// The valid result of each row from `first` to before `last`; row 0 where there is none.
  std::vector<RowResult> results(std::size_t first, std::size_t last) const;

  /// CSV of rows with a result: table and figures, and their cost.
  std::string results_csv(const std::vector<RowResult>& results) const;
  std::string machine_csv_of(const std::vector<RowResult>& results) const;
};

/// A text of an error without the folder of a run's files, which is another one each time.
std::string without_folder(std::string text, const std::filesystem::path& folder);

/// Text of a whole file. @throws base::ConfigError
std::string text_of_file(const std::filesystem::path& file);

}  // namespace cas::hils
