// SPDX-License-Identifier: BSD-3-Clause
#include "casd/casctl/doctor/doctor_facts.hpp"

namespace cas::casctl {

using nlohmann::json;

json link_named(const json& status, const std::string& name) {
  for (const json& link : status.value("links", json::array())) {
    if (link.value("name", "") == name) return link;
  }
  return json::object();
}

double rate_of(const DoctorFacts& facts, const std::string& link, const std::string& direction,
               const std::set<std::string>& names, std::optional<int> system) {
  double hz = 0;
  for (const json& message : facts.messages) {
    if (message.value("link", "") == link && message.value("direction", "") == direction &&
        names.contains(message.value("name", "")) &&
        (!system || message.value("system", 0) == *system) &&
        message.value("age_s", 1e9) < kFresh_s) {
      hz += message.value("hz", 0.0);
    }
  }
  return hz;
}

}  // namespace cas::casctl
