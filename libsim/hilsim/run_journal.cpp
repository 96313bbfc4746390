// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/hilsim/run_journal.hpp"

#include <nlohmann/json.hpp>
#include <utility>

namespace cas::sim {

namespace {

/// Whether a call drives the run on as the one before did.
bool goes_on(const NotedCall& before, const NotedCall& call) {
  if (call.client != before.client || call.method != before.method) return false;
  return call.method == "sim.run_until" ||
         (call.method == "sim.step" && call.params == before.params);
}

}  // namespace

void RunJournal::note(NotedCall call) {
  if (!entries_.empty() && goes_on(entries_.back().call, call)) {
    entries_.back().call.params = std::move(call.params);
    ++entries_.back().times;
    return;
  }
  entries_.push_back({.call = std::move(call)});
  if (entries_.size() <= kMost) return;
  entries_.pop_front();
  ++forgotten_;
}

nlohmann::json RunJournal::json() const {
  nlohmann::json calls = nlohmann::json::array();
  for (const auto& [call, times] : entries_) {
    nlohmann::json entry{{"unix_us", call.unix_us},
                         {"time_s", call.time_s},
                         {"client", call.client},
                         {"method", call.method},
                         {"params", nlohmann::json::parse(call.params)}};
    if (times > 1) entry["times"] = times;
    calls.push_back(std::move(entry));
  }
  return {{"calls", std::move(calls)}, {"forgotten", forgotten_}};
}

}  // namespace cas::sim
