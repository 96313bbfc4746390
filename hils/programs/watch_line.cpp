// SPDX-License-Identifier: BSD-3-Clause
#include "hils/programs/watch_line.hpp"

#include <fmt/format.h>

#include <cstdio>

#include "base/rpc/local_clients.hpp"

namespace cas::hils {

std::string watch_line(const std::optional<std::string>& address,
                       const std::optional<StationEndpoint>& station) {
  return fmt::format("Watch it: casctl {}monitor{}",
                     address ? fmt::format("--address {} ", *address) : "",
                     station ? "; " + to_words(*station) : "");
}

void tell_how_to_watch(const std::filesystem::path& command_port,
                       const std::optional<StationEndpoint>& station) {
  std::optional<std::string> address = "unix:" + command_port.string();
  if (base::rpc::connect_local().size() == 1) address.reset();
  fmt::print(stderr, "{}\n", watch_line(address, station));
}

}  // namespace cas::hils
