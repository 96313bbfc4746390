// SPDX-License-Identifier: BSD-3-Clause
#include "casd/casctl/session/port_owner.hpp"

#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <sstream>

#include "base/os/host_port.hpp"
#include "base/os/runtime_folder.hpp"
#include "base/read_file.hpp"

namespace cas::casctl {

std::set<uid_t> listeners(std::string_view table, unsigned port) {
  constexpr const char* kListens = "0A";
  std::set<uid_t> users;
  std::istringstream lines{std::string(table)};
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string slot, local, remote, state, queues, timer, retransmits;
    uid_t user = 0;
    words >> slot >> local >> remote >> state >> queues >> timer >> retransmits >> user;
    const std::size_t colon = local.rfind(':');
    if (!words || state != kListens || colon == std::string::npos) continue;
    if (std::strtoul(local.c_str() + colon + 1, nullptr, 16) == port) users.insert(user);
  }
  return users;
}

bool is_own_port(const std::string& port) {
  const auto number = base::parse_port(port);
  if (!number) return false;
  std::set<uid_t> users;
  for (const char* table : {"/proc/net/tcp", "/proc/net/tcp6"}) {
    users.merge(listeners(base::read_file(table).value_or(""), *number));
  }
  struct stat service {};
  const bool installed = ::lstat(base::kServiceFolder, &service) == 0;
  return !users.empty() && std::ranges::all_of(users, [&](uid_t user) {
    return user == ::geteuid() || (installed && user == service.st_uid);
  });
}

}  // namespace cas::casctl
