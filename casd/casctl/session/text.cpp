// SPDX-License-Identifier: BSD-3-Clause
#include "casd/casctl/session/text.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "base/printable.hpp"

namespace cas::casctl {
namespace {

bool numeric(const std::string& cell) {
  return cell.empty() || cell == "-" ||
         cell.find_first_not_of("0123456789.-+%") == std::string::npos;
}

}  // namespace

void Table::add(std::vector<std::string> row) {
  for (std::string& cell : row) cell = printable(std::move(cell));
  rows_.push_back(std::move(row));
}

void Table::print(std::ostream& out) const {
  const std::size_t columns = rows_.front().size();
  std::vector<std::size_t> widths(columns, 0);
  std::vector<bool> right(columns, rows_.size() > 1);
  for (std::size_t r = 0; r < rows_.size(); ++r) {
    for (std::size_t c = 0; c < columns; ++c) {
      widths[c] = std::max(widths[c], rows_[r][c].size());
      if (r > 0 && !numeric(rows_[r][c])) right[c] = false;
    }
  }
  for (const auto& row : rows_) {
    std::string line;
    for (std::size_t c = 0; c < columns; ++c) {
      const std::string pad(widths[c] - row[c].size(), ' ');
      if (c > 0) line += "  ";
      line += right[c] ? pad + row[c] : row[c] + pad;
    }
    line.erase(line.find_last_not_of(' ') + 1);
    out << line << '\n';
  }
}

std::string fixed(double value, int decimals) { return fmt::format("{:.{}f}", value, decimals); }

std::string count_text(const nlohmann::json& object, const char* key) {
  const auto found = object.find(key);
  return found == object.end() || !found->is_number() ? "-" : found->dump();
}

std::string duration_text(double seconds) {
  if (seconds < 120) return fixed(seconds, 1) + " s";
  if (seconds < 7200) return fixed(seconds / 60, 0) + " min";
  constexpr double kDay_s = 86400;
  constexpr double kYear_s = 365.25 * kDay_s;
  if (seconds < 2 * kDay_s) return fixed(seconds / 3600, 1) + " h";
  if (seconds < 2 * kYear_s) return fixed(seconds / kDay_s, 1) + " days";
  return fixed(seconds / kYear_s, 1) + " years";
}

std::string stream_text(const nlohmann::json& future) {
  return fmt::format("{}/{} (signing link {})", future.value("system", 0),
                     future.value("component", 0), future.value("link_id", 0));
}

std::string printable(std::string text) {
  std::ranges::replace(text, '\t', '?');
  return base::printable(text);
}

std::string printable_lines(std::string text) {
  std::ranges::replace(text, '\t', '?');
  return base::printable_lines(text);
}

std::string endpoint_text(const nlohmann::json& link) {
  const std::string endpoint = link.value("endpoint", "");
  const std::string remote = link.value("remote", "");
  const bool both = link.value("state", "") == "up" && !remote.empty();
  return both ? endpoint + " -> " + remote : endpoint;
}

using nlohmann::json;

std::string change_text(const json& before, const json& now) {
  return before.is_number() && before != now ? before.dump() + " -> " + now.dump() : now.dump();
}

std::string gains_text(const json& gains) {
  std::string text = gains.value("loop", "?");
  const json before = gains.value("before", json::object());
  const char* separator = ": ";
  for (const auto& [key, letter] : {std::pair{"p", "P "}, {"i", "I "}, {"d", "D "}}) {
    if (!gains.contains(key)) continue;
    text += separator + std::string(letter) + change_text(before.value(key, json()), gains[key]);
    separator = ", ";
  }
  return text;
}

std::string param_text(const json& parameter) {
  return parameter.value("name", "?") + " = " +
         change_text(parameter.value("before", json()), parameter.value("value", json()));
}

using nlohmann::json;

std::string recording_text(const json& recording) {
  const bool gaps = recording.value("left_out", 0) > 0;
  if (!recording.value("active", false)) {
    const std::string fault = recording.contains("paused")
                                  ? "CANNOT RECORD in " + recording.value("folder", "?") + ": " +
                                        recording.value("paused", "?")
                                  : "";
    if (!gaps) return fault;
    return fault + (fault.empty() ? "" : "; ") + recording["left_out"].dump() +
           " packets are missing in the last recording";
  }
  const std::string missing =
      gaps ? ", " + recording["left_out"].dump() + " packets are missing in it" : "";
  const std::string file = recording.value("file", "?");
  if (!recording.contains("paused")) {
    return "recording into " + file + ": " + count_text(recording, "recorded") + " packets" +
           missing;
  }
  return "recording PAUSED for " + duration_text(recording.value("paused_s", 0.0)) + ": " +
         recording["paused"].get<std::string>() + "; " +
         (file.empty() ? "there is no file yet"
                       : file + " has " + count_text(recording, "recorded") + " packets") +
         missing;
}

std::string autopilot_logs_text(const json& logs) {
  std::string text = "logs of autopilots in " + logs.value("folder", "?");
  if (logs.contains("paused")) {
    text += " PAUSED for " + duration_text(logs.value("paused_s", 0.0)) + ": " +
            logs.value("paused", "?");
  }
  const json vehicles = logs.value("vehicles", json::array());
  if (vehicles.empty()) text += "; no vehicle yet";
  for (const json& log : vehicles) {
    text += "\n  vehicle " + count_text(log, "vehicle") + ": ";
    text += log.contains("file")
                ? std::filesystem::path(log.value("file", "?")).filename().string() + ", " +
                      count_text(log, "bytes") + " bytes"
            : log.value("wanted", false) ? "asked, no data yet"
            : logs.contains("paused")    ? "waits for the folder"
                                         : "waits for its arming or its HEARTBEAT";
    if (log.contains("trouble")) text += "; it " + log.value("trouble", "?");
  }
  return text;
}

namespace {

using nlohmann::json;

json member(const json& object, std::string_view key) {
  return object.is_object() ? object.value(std::string(key), json()) : json();
}

}  // namespace

std::optional<std::uint64_t> counter_of(const json& link, const casd::CounterWords& words) {
  const json block = words.group.empty() ? link : member(link, words.group);
  const json value = member(block, words.key);
  if (words.kind == casd::CounterWords::Kind::kByCause) {
    std::uint64_t sum = 0;
    for (const json& count : value) {
      if (count.is_number()) sum += count.get<std::uint64_t>();
    }
    return sum;
  }
  if (!value.is_number()) return std::nullopt;
  return value.get<std::uint64_t>();
}

std::string short_count(std::uint64_t n) {
  const auto value = static_cast<double>(n);
  if (n < 10'000) return std::to_string(n);
  if (n < 1'000'000) return fixed(value / 1e3, n < 100'000 ? 1 : 0) + "k";
  if (n < 1'000'000'000) return fixed(value / 1e6, n < 100'000'000 ? 1 : 0) + "M";
  return fixed(value / 1e9, 1) + "G";
}

std::string age_text(double age_s) {
  if (age_s < 10) return fixed(std::max(age_s, 0.0), 1) + " s";
  if (age_s < 600) return fixed(age_s, 0) + " s";
  if (age_s < 7200) return fixed(age_s / 60, 0) + " min";
  return fixed(age_s / 3600, 1) + " h";
}

std::string value_text(const nlohmann::json& value) {
  if (value.is_string()) return value.get<std::string>();
  if (value.is_number_float()) return fmt::format("{:.6g}", value.get<double>());
  if (!value.is_array()) return value.is_null() ? "nan" : value.dump();
  constexpr std::size_t kMost = 4;
  std::string text;
  for (std::size_t i = 0; i < std::min(value.size(), kMost); ++i) {
    text += (text.empty() ? "" : " ") + value_text(value[i]);
  }
  if (value.size() > kMost) text += fmt::format(" and {} more", value.size() - kMost);
  return text;
}

}  // namespace cas::casctl
