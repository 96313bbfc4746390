// SPDX-License-Identifier: BSD-3-Clause
#include "casd/port/call_journal.hpp"

#include <nlohmann/json.hpp>
#include <utility>

#include "casd/port/vehicle_json.hpp"

namespace cas::casd {

using nlohmann::json;

void CallJournal::add(Call call) {
  if (call.params.size() > kMostParamsBytes) call.params.clear();
  if (call.refusal && call.refusal->size() > kMostRefusalBytes) {
    call.refusal->resize(kMostRefusalBytes);
  }
  calls_.push_back(std::move(call));
  if (calls_.size() <= kMost) return;
  calls_.pop_front();
  ++forgotten_;
}

json CallJournal::answer() const {
  json calls = json::array();
  for (const Call& call : calls_) {
    json entry{{"at_s", moment_s(call.at)},
               {"unix_us", call.unix_us},
               {"client", call.client},
               {"method", call.method},
               {"params", json::parse(call.params, nullptr, false)},
               {"vehicle", call.system}};
    if (entry["params"].is_discarded()) entry["params"] = nullptr;
    if (call.refusal) entry["refusal"] = *call.refusal;
    if (call.times > 1) entry["times"] = call.times;
    calls.push_back(std::move(entry));
  }
  return {{"calls", std::move(calls)}, {"forgotten", forgotten_}};
}

}  // namespace cas::casd
