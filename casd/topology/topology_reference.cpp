// SPDX-License-Identifier: BSD-3-Clause
#include "casd/topology/topology_reference.hpp"

#include <string_view>

#include "base/config/key_table.hpp"
#include "casd/topology/topology.hpp"

namespace cas::casd {

std::string topology_reference() {
  constexpr std::string_view kHead = "default | values | meaning |\n";
  std::string text;
  text.append("| a reload | key | ").append(kHead).append("|---|---|---|---|---|\n");
  text += base::key_lines(restart_rows(), "restart | ");
  text += base::key_lines(reload_rows(), "in force | ");

  text.append("\nOne of `links`:\n\n| type | key | ")
      .append(kHead)
      .append("|---|---|---|---|---|\n");
  text += base::key_lines(link_rows({}), "all | ");
  for (int i = 0; i <= static_cast<int>(LinkType::kTlog); ++i) {
    const auto type = static_cast<LinkType>(i);
    text += base::key_lines(link_rows(type), "`" + std::string(to_string(type)) + "` | ");
  }

  text.append("\nOne of `routes`:\n\n| key | ").append(kHead).append("|---|---|---|---|\n");
  text += base::key_lines(route_rows());
  return text;
}

}  // namespace cas::casd
