// SPDX-License-Identifier: BSD-3-Clause
#include "hils/run/station_endpoint.hpp"

#include <fmt/format.h>

#include <optional>

#include "base/error.hpp"
#include "base/os/host_port.hpp"

namespace cas::hils {

namespace {

bool is_port(const std::string& text) {
  const bool digits = !text.empty() && text.size() <= 5 &&
                      text.find_first_not_of("0123456789") == std::string::npos;
  return digits && std::stoi(text) >= 1 && std::stoi(text) <= 65535;
}

}  // namespace

StationEndpoint StationEndpoint::parse(const std::string& text) {
  const std::size_t colon = text.find(':');
  StationEndpoint station{.type = text.substr(0, colon), .address = {}};
  if (colon == std::string::npos ||
      (station.type != "udp" && station.type != "udp_server" && station.type != "tcp_server")) {
    throw base::ConfigError("--gcs '" + text +
                            "' is none of udp:PORT, udp_server:PORT, tcp_server:PORT, each also as "
                            "TYPE:HOST:PORT");
  }
  station.address = text.substr(colon + 1);
  if (station.address.find(':') == std::string::npos) {
    station.address = "127.0.0.1:" + station.address;
  }
  const std::optional<base::HostPort> parts = base::parse_host_port(station.address);
  if (!parts || !is_port(parts->port)) {
    throw base::ConfigError("--gcs '" + text + "' has no port from 1 to 65535 at its end");
  }
  return station;
}

std::string to_words(const StationEndpoint& station) {
  if (station.type == "udp") {
    return fmt::format("a ground station at {} is sent to over UDP", station.address);
  }
  return fmt::format("a ground station joins at {} over {}", station.address,
                     station.type == "udp_server" ? "UDP" : "TCP");
}

}  // namespace cas::hils
