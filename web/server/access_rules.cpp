// SPDX-License-Identifier: BSD-3-Clause
#include "web/server/access_rules.hpp"

#include <algorithm>

#include "base/text.hpp"

namespace cas::web {
namespace {

constexpr std::uint16_t kHttpPort = 80;  // browsers leave it out

using base::lower;

}  // namespace

AccessRules::AccessRules(std::uint16_t port, const std::vector<std::string>& names) {
  std::vector<std::string> all{"localhost", "127.0.0.1", "[::1]"};
  all.insert(all.end(), names.begin(), names.end());
  for (const std::string& name : all) {
    hosts_.push_back(lower(name) + ":" + std::to_string(port));
    if (port == kHttpPort) hosts_.push_back(lower(name));
  }
}

bool AccessRules::allows_host(std::string_view host) const {
  return std::find(hosts_.begin(), hosts_.end(), lower(host)) != hosts_.end();
}

bool AccessRules::allows_origin(std::string_view origin, std::string_view host) const {
  return allows_host(host) && lower(origin) == "http://" + lower(host);
}

}  // namespace cas::web
