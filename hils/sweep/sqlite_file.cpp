// SPDX-License-Identifier: BSD-3-Clause
#include "hils/sweep/sqlite_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sqlite3.h>
#include <unistd.h>

#include <cmath>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "base/os/descriptor.hpp"

namespace cas::hils {

namespace {

namespace fs = std::filesystem;

struct Close {
  void operator()(sqlite3* database) const { sqlite3_close(database); }
  void operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }
};

/// A name in double quotes, as SQL has it.
std::string name_text(const std::string& name) {
  std::string text = "\"";
  for (const char c : name) {
    if (c == '"') text += '"';
    text += c;
  }
  return text + "\"";
}

class Database {
 public:
  explicit Database(const fs::path& file) : file_(file) {
    sqlite3* raw = nullptr;
    const int code =
        sqlite3_open_v2(file.c_str(), &raw, SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE, nullptr);
    database_.reset(raw);
    check(code);
  }

  void run(const std::string& sql) {
    check(sqlite3_exec(database_.get(), sql.c_str(), nullptr, nullptr, nullptr));
  }

  void prepare(const std::string& sql) {
    sqlite3_stmt* raw = nullptr;
    check(sqlite3_prepare_v2(database_.get(), sql.c_str(), -1, &raw, nullptr));
    statement_.reset(raw);
    next_ = 1;
  }
  void bind(const std::string& text) {
    check(sqlite3_bind_text(statement_.get(), next_++, text.c_str(), -1, SQLITE_TRANSIENT));
  }
  void bind(double value) {
    if (!std::isfinite(value)) {
      ++next_;  // stays NULL
      return;
    }
    check(sqlite3_bind_double(statement_.get(), next_++, value));
  }
  void bind_whole(std::uint64_t value) {
    check(sqlite3_bind_int64(statement_.get(), next_++, static_cast<sqlite3_int64>(value)));
  }
  /// Does the insertion, and begins the next one.
  void step() {
    if (const int code = sqlite3_step(statement_.get()); code != SQLITE_DONE) check(code);
    check(sqlite3_reset(statement_.get()));
    check(sqlite3_clear_bindings(statement_.get()));
    next_ = 1;
  }
  void close() { statement_.reset(); }

 private:
  void check(int code) const {
    if (code == SQLITE_OK) return;
    throw base::ConfigError(file_.string() + ": cannot be written: " +
                            (database_ ? sqlite3_errmsg(database_.get()) : sqlite3_errstr(code)));
  }

  fs::path file_;
  std::unique_ptr<sqlite3, Close> database_;
  std::unique_ptr<sqlite3_stmt, Close> statement_;
  int next_ = 1;
};

/// "?, ?, ?"
std::string places(std::size_t count) {
  std::string text;
  for (std::size_t i = 0; i < count; ++i) text += i == 0 ? "?" : ", ?";
  return text;
}

void write_runs(const SweepView& view, Database& database) {
  const SweepFolder& sweep = view.sweep;
  std::string columns = "row INTEGER PRIMARY KEY, point INTEGER, seed INTEGER";
  std::vector<std::vector<double>> numbers;
  for (std::size_t i = 0; i < sweep.table.names.size(); ++i) {
    numbers.push_back(view.numbers(i));
    columns += ", " + name_text(sweep.table.names[i]) + (numbers[i].empty() ? " TEXT" : " REAL");
  }
  columns += ", outcome TEXT";
  for (const std::string& name : sweep.figures) columns += ", " + name_text(name) + " REAL";
  columns += ", incident TEXT, cause TEXT, version TEXT, truth_sha256 TEXT";
  database.run("CREATE TABLE runs (" + columns + ")");
  database.prepare("INSERT INTO runs VALUES (" +
                   places(sweep.table.names.size() + sweep.figures.size() + 8) + ")");
  for (const RowResult& result : view.results) {
    if (result.row == 0) continue;
    const TableRow& row = sweep.row(result.row);
    database.bind_whole(row.row);
    database.bind_whole(row.point);
    database.bind_whole(row.seed);
    for (std::size_t i = 0; i < row.values.size(); ++i) {
      numbers[i].empty() ? database.bind(row.values[i]) : database.bind(numbers[i][row.row - 1]);
    }
    database.bind(std::string(to_string(result.outcome)));
    for (std::size_t i = 0; i < sweep.figures.size(); ++i) {
      database.bind(i < result.figures.size() ? result.figures[i] : std::nan(""));
    }
    database.bind(result.incident);
    database.bind(result.cause);
    database.bind(result.version);
    database.bind(result.truth_sha256);
    database.step();
  }
}

void write_machine(const SweepView& view, Database& database) {
  database.run(
      "CREATE TABLE machine (row INTEGER PRIMARY KEY, wall_s REAL, cpu_s REAL, max_rss_mib REAL, "
      "host TEXT)");
  database.prepare("INSERT INTO machine VALUES (" + places(5) + ")");
  for (const RowResult& result : view.results) {
    if (result.row == 0) continue;
    database.bind_whole(result.row);
    database.bind(result.machine.wall_s);
    database.bind(result.machine.cpu_s);
    database.bind(result.machine.max_rss_mib);
    database.bind(result.machine.host);
    database.step();
  }
}

void write_study(const SweepView& view, Database& database) {
  database.run("CREATE TABLE study (key TEXT PRIMARY KEY, value TEXT)");
  database.prepare("INSERT INTO study VALUES (?, ?)");
  const auto put = [&database](const std::string& key, const std::string& value) {
    database.bind(key);
    database.bind(value);
    database.step();
  };
  put("name", view.sweep.study.name);
  put("description", view.sweep.study.description);
  put("rows", std::to_string(view.sweep.table.rows.size()));
  put("study.yaml", text_of_file(view.sweep.path / "study.yaml"));
  put("scenario.yaml", text_of_file(view.sweep.scenario()));
}

void sync(const fs::path& file, int flags) {
  const base::Descriptor descriptor(::open(file.c_str(), flags | O_CLOEXEC));
  if (descriptor) ::fsync(descriptor.get());
}

}  // namespace

void write_sqlite(const SweepView& view, const fs::path& file) {
  const fs::path beside = fmt::format("{}.{}.new", file.string(), ::getpid());
  std::error_code ignored;
  fs::remove(beside, ignored);
  try {
    Database database(beside);
    database.run("PRAGMA journal_mode = OFF; PRAGMA synchronous = OFF; BEGIN");
    write_runs(view, database);
    write_machine(view, database);
    write_study(view, database);
    database.close();
    database.run("COMMIT");
  } catch (...) {
    fs::remove(beside, ignored);
    throw;
  }
  sync(beside, O_RDONLY);
  std::error_code error;
  fs::rename(beside, file, error);
  if (error) {
    fs::remove(beside, ignored);
    throw base::ConfigError(file.string() + ": cannot be written: " + error.message());
  }
  sync(file.parent_path(), O_RDONLY | O_DIRECTORY);
}

}  // namespace cas::hils
