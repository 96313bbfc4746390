// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <ostream>
#include <string>
#include <vector>

#include "casd/words/link_words.hpp"

namespace cas::casctl {

/// A plain text table: columns as wide as their widest cell, numbers to the right.
class Table {
 public:
  explicit Table(std::vector<std::string> header) : rows_{std::move(header)} {}
  /// Control characters in it are shown as `?`.
  void add(std::vector<std::string> row);
  bool empty() const { return rows_.size() == 1; }
  void print(std::ostream& out) const;

 private:
  std::vector<std::vector<std::string>> rows_;
};

/// A number with a fixed count of decimals.
std::string fixed(double value, int decimals);
/// A number of an object; "-": it has none.
std::string count_text(const nlohmann::json& object, const char* key);
/// A duration in words of one unit: "0.4 s", "12 min", "3.1 h", "9.5 days", "10.0 years".
std::string duration_text(double seconds);
/// The signer, from `future` of link.list: "1/200 (signing link 3)".
std::string stream_text(const nlohmann::json& future);

/// With `?` in the place of each control character and each invisible one: texts come from the
/// wire, and must neither move the cursor nor give a terminal orders.
std::string printable(std::string text);
/// The same, but lines end where they did.
std::string printable_lines(std::string text);

/// Where a link is bound and where it sends: "127.0.0.1:49428 -> 10.0.0.2:14550"; the reason while
/// it is down.
/// @param link  as casd.status tells it
std::string endpoint_text(const nlohmann::json& link);

/// "1.5 -> 1.2", or "1.2" if unchanged, or if the old value is unknown (null).
std::string change_text(const nlohmann::json& before, const nlohmann::json& now);

/// An answer of gain.set or gain.get: "rollrate: P 0.15 -> 0.16, I 0.2, D 0.003".
std::string gains_text(const nlohmann::json& gains);

/// An answer of param.set or param.get: "MC_ROLL_P = 6.5 -> 7".
std::string param_text(const nlohmann::json& parameter);

/// "recording into FILE: 120 packets", "recording PAUSED for 3 s: ...", "CANNOT RECORD: ...", ""
/// where nothing is recorded.
/// @param recording  as log.status tells it
std::string recording_text(const nlohmann::json& recording);

/// "logs of autopilots in FOLDER PAUSED for 3 s: ...", then a line for each vehicle.
/// @param logs  `autopilot_logs` of casd.status
std::string autopilot_logs_text(const nlohmann::json& logs);

/// A counter of a link as casd.status tells it, of one by cause the sum; nullopt: casd does not
/// tell it.
std::optional<std::uint64_t> counter_of(const nlohmann::json& link,
                                        const casd::CounterWords& words);

/// Older values are shown as old, or not at all: vehicles send the slowest of the messages that
/// casctl shows every other second.
inline constexpr double kStale_s = 3;

/// "12", "3.4k", "1.2M": five columns at most.
std::string short_count(std::uint64_t n);
/// "0.4 s", "12 s", "3 min".
std::string age_text(double age_s);
/// A value as casd tells it: of an array its first four elements.
std::string value_text(const nlohmann::json& value);

}  // namespace cas::casctl
