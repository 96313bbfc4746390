// SPDX-License-Identifier: BSD-3-Clause
#include "casd/casctl/session/endpoint_text.hpp"

namespace cas::casctl {

std::string endpoint_text(const nlohmann::json& link) {
  const std::string endpoint = link.value("endpoint", "");
  const std::string remote = link.value("remote", "");
  const bool both = link.value("state", "") == "up" && !remote.empty();
  return both ? endpoint + " -> " + remote : endpoint;
}

}  // namespace cas::casctl
