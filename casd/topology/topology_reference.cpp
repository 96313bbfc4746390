// SPDX-License-Identifier: BSD-3-Clause
#include "casd/topology/topology_reference.hpp"

#include <algorithm>
#include <string_view>
#include <utility>
#include <vector>

#include "base/config/key_table.hpp"
#include "casd/topology/topology.hpp"

namespace cas::casd {
namespace {

/// The lines of links' keys, each once with all types that have it alike.
std::string lines_by_type() {
  std::vector<std::pair<std::string, std::string>> lines;  // types of a line, and it
  for (int i = 0; i <= static_cast<int>(LinkType::kTlog); ++i) {
    const auto type = static_cast<LinkType>(i);
    for (const base::KeyRow& row : link_rows(type)) {
      const std::string line = base::key_lines({row}, " | ");
      auto found = std::ranges::find(lines, line, &std::pair<std::string, std::string>::second);
      if (found == lines.end()) found = lines.insert(found, {"", line});
      found->first += (found->first.empty() ? "`" : ", `") + std::string(to_string(type)) + "`";
    }
  }
  std::string text;
  for (const auto& [types, line] : lines) text += line.substr(0, 2) + types + line.substr(2);
  return text;
}

}  // namespace

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
  text += lines_by_type();

  text.append("\nOne of `routes`:\n\n| key | ").append(kHead).append("|---|---|---|---|\n");
  text += base::key_lines(route_rows());
  return text;
}

}  // namespace cas::casd
