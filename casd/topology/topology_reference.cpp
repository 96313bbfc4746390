// SPDX-License-Identifier: BSD-3-Clause
#include "casd/topology/topology_reference.hpp"

#include <string_view>
#include <vector>

#include "base/config/config_keys.hpp"
#include "casd/topology/topology.hpp"

namespace cas::casd {
namespace {

void add(std::string& text, std::string_view first, const std::vector<base::KeyRow>& rows) {
  for (const base::KeyRow& row : rows) {
    text.append("| ").append(first).append("`" + row.key + "` | " + row.standard + " | " +
                                           row.values + " | " + row.help + " |\n");
  }
}

}  // namespace

std::string topology_reference() {
  constexpr std::string_view kHead = "default | values | meaning |\n";
  std::string text;
  text.append("| a reload | key | ").append(kHead).append("|---|---|---|---|---|\n");
  add(text, "restart | ", restart_rows());
  add(text, "in force | ", reload_rows());

  text.append("\nOne of `links`:\n\n| type | key | ")
      .append(kHead)
      .append("|---|---|---|---|---|\n");
  add(text, "all | ", link_rows({}));
  for (int i = 0; i <= static_cast<int>(LinkType::kTlog); ++i) {
    const auto type = static_cast<LinkType>(i);
    add(text, "`" + std::string(to_string(type)) + "` | ", link_rows(type));
  }

  text.append("\nOne of `routes`:\n\n| key | ").append(kHead).append("|---|---|---|---|\n");
  add(text, "", route_rows());
  return text;
}

}  // namespace cas::casd
