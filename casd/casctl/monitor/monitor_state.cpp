// SPDX-License-Identifier: BSD-3-Clause
#include "casd/casctl/monitor/monitor_state.hpp"

#include <algorithm>

#include "base/text.hpp"

namespace cas::casctl {
namespace {

using nlohmann::json;

}  // namespace

Presence presence(const MonitorState& state, double now_s) {
  const double look_age_s = now_s - state.status_at_s;
  const double late_s = overdue_s(state, state.status_at_s, now_s);
  if (is_stale(state, now_s)) return {.kind = Presence::Kind::kUnknown, .age_s = look_age_s};
  const json vehicles = state.status.value("vehicles", json::array());
  for (const json& vehicle : vehicles) {
    if (state.chosen_vehicle && vehicle.value("system", 0) != *state.chosen_vehicle) continue;
    const auto watch = state.watches.find(vehicle.value("system", 0));
    const double silent_s =
        watch == state.watches.end() ? 0 : state.status_at_s - watch->second.changed_at_s;
    const double told_s = std::max(vehicle.value("heartbeat_age_s", 0.0), silent_s);
    const double age_s = told_s + look_age_s;
    const double stale_s = std::max(kStale_s, vehicle.value("silent_after_s", 0.0));
    return {.kind = told_s + late_s > stale_s ? Presence::Kind::kLost : Presence::Kind::kHere,
            .age_s = age_s,
            .summary = vehicle};
  }
  return {.kind = Presence::Kind::kNone};
}

double overdue_s(const MonitorState& state, double at_s, double now_s) {
  return std::max(now_s - at_s - state.interval_s, 0.0);
}

bool is_stale(const MonitorState& state, double now_s) {
  return state.casd_fault || overdue_s(state, state.status_at_s, now_s) > kStale_s;
}

std::vector<MessageRow> visible_rows(const MonitorState& state) {
  std::vector<MessageRow> shown;
  const std::string wanted = base::lower(state.filter);
  for (const MessageRow& row : state.rows) {
    if (!state.link.empty() && row.key.link != state.link) continue;
    if (!state.direction.empty() && row.key.direction.rfind(state.direction, 0) != 0) continue;
    if (base::lower(row.key.name).find(wanted) == std::string::npos) continue;
    shown.push_back(row);
  }
  using Sort = MonitorState::Sort;
  std::stable_sort(shown.begin(), shown.end(), [&](const MessageRow& a, const MessageRow& b) {
    if (state.sort == Sort::kRate && a.hz != b.hz) return a.hz > b.hz;
    if (state.sort == Sort::kAge && a.age_s != b.age_s) return a.age_s < b.age_s;
    if (state.sort == Sort::kCount && a.count != b.count) return a.count > b.count;
    return a.key < b.key;
  });
  return shown;
}

}  // namespace cas::casctl
