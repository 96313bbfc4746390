// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "casd/casctl/monitor/attitude_view.hpp"
#include "casd/casctl/monitor/plot.hpp"
#include "casd/casctl/session/text.hpp"

namespace cas::casctl {

/// One message of one sender on one link.
struct MessageKey {
  std::string link, direction, name;
  int id = 0, system = 0, component = 0;
  auto operator<=>(const MessageKey&) const = default;
};

struct MessageRow {
  MessageKey key;
  double hz = 0, age_s = 0;
  std::uint64_t count = 0;
};

struct LinkRate {
  double rx_packets_s = 0, tx_packets_s = 0;
  std::uint64_t rx = 0, tx = 0;
};

/// When something of a vehicle was last seen to come, by the count of its messages. In lockstep
/// casd's time stops with the stream, and so do the ages in its answers.
struct VehicleWatch {
  std::uint64_t count = 0;
  double changed_at_s = 0;
};

/// State from which the screen is drawn: casd's last answers with their times of arrival, and the
/// user's place on the screen. Times are those of one steady clock, s.
struct MonitorState {
  enum class Sort { kName, kRate, kAge, kCount };
  /// The part that the keys act on; a narrow screen shows only this part.
  enum class Page { kMessages, kVehicle, kGains, kHelp };

  nlohmann::json status = nlohmann::json::object();     ///< casd.status
  nlohmann::json vehicle = nlohmann::json::object();    ///< vehicle.state
  nlohmann::json telemetry = nlohmann::json::object();  ///< vehicle.telemetry
  nlohmann::json value = nlohmann::json::object();      ///< message.value of the open message
  nlohmann::json gains = nlohmann::json::array();       ///< gain.get of each loop
  double status_at_s = 0, vehicle_at_s = 0, rows_at_s = 0, value_at_s = 0, gains_at_s = 0;
  double interval_s = 0.5;                 ///< between two looks at casd
  std::optional<std::string> casd_fault;   ///< why casd does not answer; nullopt: it does
  std::optional<std::string> gains_fault;  ///< why there are no gains
  std::optional<double> gains_asked_s;     ///< since when they are being asked for
  std::vector<MessageRow> rows;
  std::map<std::string, LinkRate> link_rates;
  std::map<std::string, std::deque<Sample>> history;  ///< of the open message's numbers
  std::deque<Place> trail;
  std::map<int, VehicleWatch> watches;  ///< by system id

  std::optional<int> chosen_vehicle;  ///< system id; nullopt: the first one
  std::optional<MessageKey> selected;
  std::optional<MessageKey> open;
  std::size_t selected_gain = 0;
  std::size_t selected_field = 0;  ///< of the open message: the one that is plotted
  bool is_field_chosen = false;    ///< by the user
  std::size_t help_top = 0;
  Sort sort = Sort::kName;
  Page page = Page::kMessages;
  std::string link;       ///< filter; empty: all
  std::string direction;  ///< filter; empty: all
  std::string filter;     ///< of names
  bool paused = false;
  bool unicode = true;
  std::string note;  ///< about the last key
  bool note_bad = false;
  std::string answer;  ///< of the last command
  double answer_at_s = 0;
  bool answer_bad = false;
  std::optional<std::string> prompt;  ///< the line under edit
  std::string hint;                   ///< about it: usage, offers
};

/// Whether there is a vehicle to be shown.
struct Presence {
  enum class Kind { kUnknown, kNone, kLost, kHere };
  Kind kind = Kind::kUnknown;
  double age_s = 0;  ///< of its last HEARTBEAT, or since casd is silent
  nlohmann::json summary = nlohmann::json::object();  ///< of casd.status
};
/// A vehicle is lost 3 s after its last HEARTBEAT, as casd's interlock counts, or when nothing of
/// it came for 3 s; it is unknown while casd does not answer.
Presence presence(const MonitorState& state, double now_s);

/// For how long, s, an answer is older than it need be: by more than the time between two looks.
double overdue_s(const MonitorState& state, double at_s, double now_s);

/// Whether casd's last answer is too old to be shown as the present.
bool is_stale(const MonitorState& state, double now_s);

/// The rows that the filters leave, in order.
std::vector<MessageRow> visible_rows(const MonitorState& state);

}  // namespace cas::casctl
