// SPDX-License-Identifier: BSD-3-Clause
#include "hils/sweep/sweep_folder.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "base/error.hpp"
#include "base/os/result_file.hpp"
#include "base/read_file.hpp"
#include "base/text.hpp"
#include "hils/report/results_folder.hpp"
#include "hils/scenario/scenario.hpp"

namespace cas::hils {

namespace {

namespace fs = std::filesystem;

constexpr int kPlanSchema = 1;
constexpr std::size_t kMostBytes = std::size_t{1} << 30U;  // of a file: 10 000 rows have 20 MB
/// Most rows whose scenario is checked when a study is planned: those with the ends of a parameter.
constexpr std::size_t kMostChecked = 64;

/// Headings of the results' table, of which SQL knows no capitals.
void check_headings(const Study& study, const std::vector<std::string>& figures) {
  std::set<std::string> taken{"row",      "point", "seed",    "outcome",
                              "incident", "cause", "version", "truth_sha256"};
  for (const std::string& figure : figures) {
    if (!taken.insert(base::lower(figure)).second) {
      throw base::ConfigError("two columns of the results would be called '" + figure +
                              "': give the scenario's steps different names");
    }
  }
  for (const Parameter& parameter : study.parameters) {
    if (taken.contains(base::lower(parameter.name))) {
      throw base::ConfigError("the parameter '" + parameter.name +
                              "' is called as a column of the results; give it another 'name'");
    }
  }
}

/// Rows in which some parameter has its first, its smallest or its largest value.
std::vector<std::size_t> rows_to_check(const RunTable& table) {
  std::vector<std::size_t> rows{1};
  const auto value = [](const std::string& text) {
    double number = 0;
    std::from_chars(text.data(), text.data() + text.size(), number);
    return number;
  };
  for (std::size_t i = 0; i < table.names.size(); ++i) {
    const auto by_value = [&](const TableRow& a, const TableRow& b) {
      return value(a.values[i]) < value(b.values[i]);
    };
    const auto [least, most] = std::ranges::minmax_element(table.rows, by_value);
    rows.push_back(least->row);
    rows.push_back(most->row);
  }
  std::ranges::sort(rows);
  rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
  if (rows.size() > kMostChecked) rows.resize(kMostChecked);
  return rows;
}

/// Reads the scenarios of some rows, to find faults of all rows. @throws base::ConfigError
void check_rows(const SweepFolder& folder) {
  const fs::path scratch = folder.path / "work" / "check";
  base::make_result_folder({folder.path, scratch});
  for (const std::size_t number : rows_to_check(folder.table)) {
    const TableRow& row = folder.row(number);
    try {
      write_scenario(folder.scenario(), folder.values_of(row), folder.study_folder, scratch);
      Scenario::load(scratch / "scenario.yaml");
    } catch (const base::ConfigError& error) {
      base::remove_result_folder({folder.path, scratch});
      throw base::ConfigError(
          fmt::format("row {}: {}", number, without_folder(error.what(), scratch)));
    }
  }
  base::remove_result_folder({folder.path, scratch});
  std::error_code others;
  fs::remove(folder.path / "work", others);  // unless others have files there
}

std::string plan_json(const SweepFolder& folder) {
  nlohmann::ordered_json json;
  json["schema"] = kPlanSchema;
  json["study"] = folder.study.name;
  json["study_folder"] = folder.study_folder.string();
  json["rows"] = folder.table.rows.size();
  json["version"] = CAS_VERSION;
  json["figures"] = folder.figures;
  return json.dump(2) + "\n";
}

/// Writes the files of a plan. plan.json comes last, because it makes the folder a plan; the others
/// are on the disk by then.
void write_plan(const SweepFolder& sweep, const std::string& study) {
  const auto write = [&sweep](const fs::path& file, const std::string& text) {
    base::write_result({sweep.path, file}, text, base::Durability::kDisk);
  };
  write("study.yaml", study);
  for (const fs::directory_entry& entry : fs::directory_iterator(sweep.path)) {
    if (entry.path().extension() == ".yaml") write(entry.path(), text_of_file(entry.path()));
  }
  write("table.csv", sweep.table.csv());
  write("plan.json", plan_json(sweep));
}

}  // namespace

std::string without_folder(std::string text, const fs::path& folder) {
  if (folder.empty()) return text;
  const std::string prefix = folder.string() + "/";
  for (std::size_t at = text.find(prefix); at != std::string::npos; at = text.find(prefix)) {
    text.erase(at, prefix.size());
  }
  return text;
}

std::string text_of_file(const fs::path& file) {
  return base::read_foreign_file(file, "file", kMostBytes);
}

Chunk Chunk::parse(const std::string& text) {
  Chunk chunk;
  const char* const end = text.data() + text.size();
  const auto first = std::from_chars(text.data(), end, chunk.k);
  const bool slash = first.ec == std::errc{} && first.ptr != end && *first.ptr == '/';
  const auto second = slash ? std::from_chars(first.ptr + 1, end, chunk.n) : first;
  if (!slash || second.ec != std::errc{} || second.ptr != end || chunk.k < 1 || chunk.k > chunk.n) {
    throw base::ConfigError("--chunk '" + text + "' is no part such as 2/3: the second of three");
  }
  return chunk;
}

std::string Chunk::name() const { return fmt::format("chunk_{}_of_{}", k, n); }

SweepFolder SweepFolder::plan(const fs::path& study_file, const fs::path& folder,
                              const fs::path& files_from) {
  SweepFolder sweep{.path = fs::absolute(folder),
                    .study = Study::load(study_file),
                    .table = {},
                    .figures = {},
                    .study_folder = files_from.empty() ? fs::absolute(study_file).parent_path()
                                                       : fs::absolute(files_from)};
  const std::string text = text_of_file(study_file);
  if (fs::exists(sweep.path / "plan.json")) {
    if (text_of_file(sweep.path / "study.yaml") != text) {
      throw base::ConfigError(folder.string() +
                              ": holds another study, or this one before it was changed; its runs "
                              "stay as they are: choose another folder");
    }
    return open(folder);
  }
  std::error_code none;
  const fs::path scenario_folder = fs::absolute(Study::scenario_of(study_file)).parent_path();
  if (fs::equivalent(sweep.path, sweep.study_folder, none) ||
      fs::equivalent(sweep.path, scenario_folder, none)) {
    throw base::ConfigError(folder.string() +
                            ": holds the study or its scenario, which the sweep would write over: "
                            "choose another folder");
  }
  make_results_folder(sweep.path);
  write_scenario(Study::scenario_of(study_file), sweep.study.settings, sweep.study_folder,
                 sweep.path, {"vehicle"});
  const Scenario scenario = Scenario::load(sweep.scenario());
  sweep.table = RunTable::of(sweep.study, scenario.seed);
  sweep.figures = figure_names(scenario);
  check_headings(sweep.study, sweep.figures);
  check_rows(sweep);
  write_plan(sweep, text);
  return sweep;
}

SweepFolder SweepFolder::open(const fs::path& folder) {
  const fs::path plan_file = folder / "plan.json";
  if (!fs::exists(plan_file)) {
    throw base::ConfigError(folder.string() +
                            ": holds no sweep; 'hils sweep plan STUDY.yaml --out " +
                            folder.string() + "' plans one");
  }
  const nlohmann::json plan = nlohmann::json::parse(text_of_file(plan_file), nullptr, false);
  if (!plan.is_object() || plan.value("schema", 0) != kPlanSchema) {
    throw base::ConfigError(plan_file.string() + ": is no plan that this version of hils reads");
  }
  const fs::path table_file = folder / "table.csv";
  SweepFolder sweep{.path = fs::absolute(folder),
                    .study = Study::load(folder / "study.yaml"),
                    .table = RunTable::parse(text_of_file(table_file), table_file.string()),
                    .figures = {},
                    .study_folder = plan.value("study_folder", std::string())};
  sweep.figures = figure_names(Scenario::load(sweep.scenario()));
  if (plan.contains("figures") && plan["figures"] != nlohmann::json(sweep.figures)) {
    throw base::ConfigError(plan_file.string() + ": was planned by CAS " +
                            plan.value("version", std::string("?")) + ", whose figures are others");
  }
  if (sweep.table.rows.size() != plan.value("rows", std::size_t{0})) {
    throw base::ConfigError(fmt::format("{}: has {} rows; {} were planned", table_file.string(),
                                        sweep.table.rows.size(),
                                        plan.value("rows", std::size_t{0})));
  }
  return sweep;
}

std::vector<KeyValue> SweepFolder::values_of(const TableRow& row) const {
  std::vector<KeyValue> values;
  for (std::size_t i = 0; i < study.parameters.size(); ++i) {
    for (const std::string& key : study.parameters[i].keys) values.emplace_back(key, row.values[i]);
  }
  return values;
}

const TableRow& SweepFolder::row(std::size_t row) const {
  if (row < 1 || row > table.rows.size()) {
    throw base::ConfigError(
        fmt::format("there is no row {}; the sweep has 1 to {}", row, table.rows.size()));
  }
  return table.rows[row - 1];
}

void SweepFolder::for_each_result(const std::function<void(RowResult&&)>& visit) const {
  std::vector<fs::path> journals;
  std::error_code error;
  for (fs::directory_iterator entry(path / "journal", error), end; !error && entry != end;
       entry.increment(error)) {
    if (entry->path().extension() == ".jsonl") journals.push_back(entry->path());
  }
  if (error && error != std::errc::no_such_file_or_directory) {
    throw base::ConfigError((path / "journal").string() + ": " + error.message());
  }
  std::ranges::sort(journals);
  for (const fs::path& journal : journals) {
    std::istringstream lines(text_of_file(journal));
    for (std::string line; std::getline(lines, line);) {
      std::optional<RowResult> result = parse_journal_line(line);
      if (result && result->row <= table.rows.size()) visit(std::move(*result));
    }
  }
}

std::vector<RowResult> SweepFolder::results(std::size_t first, std::size_t last) const {
  std::vector<RowResult> rows(last - first);
  for_each_result([&](RowResult&& result) {
    if (result.row < first || result.row >= last) return;
    RowResult& known = rows[result.row - first];
    if (known.row == 0 || is_broken(known.outcome) || !is_broken(result.outcome)) {
      known = std::move(result);
    }
  });
  return rows;
}

std::string SweepFolder::results_csv(const std::vector<RowResult>& results) const {
  std::string text = "row,point,seed";
  for (const std::string& name : table.names) text += "," + csv_field(name);
  text += result_headings(figures) + "\n";
  for (const RowResult& result : results) {
    if (result.row == 0) continue;
    const TableRow& own = row(result.row);
    text += fmt::format("{},{},{}", own.row, own.point, own.seed);
    for (const std::string& value : own.values) text += "," + csv_field(value);
    text += result_fields(result, figures.size()) + "\n";
  }
  return text;
}

std::string SweepFolder::machine_csv_of(const std::vector<RowResult>& results) const {
  std::string text = machine_headings() + "\n";
  for (const RowResult& result : results) {
    if (result.row != 0) text += machine_line(result) + "\n";
  }
  return text;
}

}  // namespace cas::hils
