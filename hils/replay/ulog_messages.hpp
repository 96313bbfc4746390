// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

namespace cas::hils {

inline constexpr std::size_t kMostUlogNumbers = 3'000'000;  ///< that a page holds with ease

/// Losses of a log.
struct UlogLoss {
  std::int64_t dropped_ms = 0;    ///< that the vehicle's storage did not keep
  std::size_t damaged_bytes = 0;  ///< that are no messages
  std::size_t cut_bytes = 0;      ///< of a message that the log ends within
  std::size_t wrong_stamps = 0;   ///< messages, left out

  /// "300 ms are missing, 20 bytes are damaged, it ends within a message"; empty: nothing is lost.
  std::string sentence() const;
};

/// Contents of a vehicle's own log, in PX4's ULog format, for the page:
///
///   log:    as logged_messages() gives it, with each topic as a message. A state's mode is a word.
///           Where a topic has the attitude `q`, its `roll`, `pitch` and `yaw` are there, too
///   events: changed parameters, and losses of the log
///   system: the vehicle's
///   truth, reference, origin: the true motion and the setpoints, as UlogTruth has them
///   controller: its hardware, "PX4_FMU_V5X"; empty where the log does not say
///
/// Numbers come at 20 Hz. Time counts from the begin of the log.
///
/// @param most_numbers  that the page can hold; of a longer log those that nothing is drawn from
///                      come less often
/// @param loss          of the whole log, if it is asked for
/// @throws base::ConfigError when it cannot be read, or has no messages
nlohmann::ordered_json ulog_messages(std::string_view bytes,
                                     std::size_t most_numbers = kMostUlogNumbers,
                                     UlogLoss* loss = nullptr);

}  // namespace cas::hils
