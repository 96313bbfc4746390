// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace cas::hils {

/// Where a ground station joins a run (`hils run --gcs`).
struct StationEndpoint {
  std::string type;     ///< of casd's link: udp, udp_server or tcp_server
  std::string address;  ///< "HOST:PORT": where the station listens (udp), or casd does (servers)
  bool inject_failures = false;  ///< it may have failures strike in the simulator

  /// Takes "TYPE:PORT", which is at 127.0.0.1, or "TYPE:HOST:PORT". @throws base::ConfigError
  static StationEndpoint parse(const std::string& text);

  /// Whether casd listens for the station; else it sends to it.
  bool is_server() const { return type != "udp"; }
};

/// How a station gets there: "a ground station at 127.0.0.1:14550 is sent to over UDP".
std::string to_words(const StationEndpoint& station);

}  // namespace cas::hils
