// SPDX-License-Identifier: BSD-3-Clause
#include "hils/programs/watch_line.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <system_error>

#include "base/rpc/local_clients.hpp"
#include "hils/programs/child_process.hpp"

namespace cas::hils {

namespace {

bool can_be_run(const std::filesystem::path& program) {
  std::error_code error;
  return std::filesystem::is_regular_file(program, error) && ::access(program.c_str(), X_OK) == 0;
}

std::string casctl_of_this_machine() {
  std::error_code error;
  const char* const path = std::getenv("PATH");
  return casctl_command(own_program().parent_path(), std::filesystem::current_path(error),
                        path == nullptr ? "" : path);
}

}  // namespace

std::string casctl_command(const std::filesystem::path& program_folder,
                           const std::filesystem::path& working_folder,
                           std::string_view search_path) {
  constexpr const char* kName = "casctl";
  while (!search_path.empty()) {
    const std::size_t end = std::min(search_path.find(':'), search_path.size());
    const std::filesystem::path folder(search_path.substr(0, end));
    if (!folder.empty() && can_be_run(folder / kName)) return kName;
    search_path.remove_prefix(std::min(end + 1, search_path.size()));
  }
  const std::filesystem::path beside = program_folder / kName;
  if (!can_be_run(beside)) return kName;
  const std::filesystem::path from_here = beside.lexically_relative(working_folder);
  const bool is_below = !from_here.empty() && *from_here.begin() != "..";
  if (!is_below) return beside.string();
  // Without a slash a shell would look through PATH.
  return from_here.has_parent_path() ? from_here.string() : "./" + from_here.string();
}

std::string watch_line(const std::string& casctl, const std::optional<std::string>& address,
                       const std::optional<StationEndpoint>& station) {
  return fmt::format("Watch it: {} {}monitor{}", casctl,
                     address ? fmt::format("--address {} ", *address) : "",
                     station ? "; " + to_words(*station) : "");
}

void tell_how_to_watch(const std::filesystem::path& command_port,
                       const std::optional<StationEndpoint>& station) {
  std::optional<std::string> address = "unix:" + command_port.string();
  if (base::rpc::connect_local().size() == 1) address.reset();
  fmt::print(stderr, "{}\n", watch_line(casctl_of_this_machine(), address, station));
}

}  // namespace cas::hils
