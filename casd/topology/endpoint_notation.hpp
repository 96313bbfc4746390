// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "casd/topology/link_config.hpp"

namespace cas::casd {

/// What an endpoint without a direction of its own means.
enum class EndpointUse : std::uint8_t {
  kPlain,   ///< mavlink-router: HOST:PORT is listened on
  kMaster,  ///< MAVProxy's --master: HOST:PORT and udp:HOST:PORT are listened on
  kOut,     ///< MAVProxy's --out, mavlink-router's -e: HOST:PORT and udp:HOST:PORT are sent to
};

/// A link of one word of a command line, without a name:
///
///     serial:/dev/ttyACM0:921600   /dev/ttyACM0,921600   serial:///dev/ttyACM0:921600
///     serial:/dev/ttyS1:57600,115200   with rates to try; serial_flowcontrol: with RTS/CTS
///     udp:14550  udpin:HOST:PORT  udps:HOST:PORT         listens; without a host on 127.0.0.1
///     udp:HOST:PORT  udpout:HOST:PORT  udpc:HOST:PORT    sends there
///     mcast:  mcast:GROUP:PORT                           sends to the group, receives from it
///     tcp:5760  tcpin:HOST:PORT  tcps:HOST:PORT          listens
///     tcp:HOST:PORT  tcpout:HOST:PORT  tcpc:HOST:PORT    connects
///
/// `udp` and `tcp` listen on a wildcard host (0.0.0.0, [::]). Serial lines pass unknown messages.
/// @param before  other links of the command line: with kOut, HOST without a port gets the
///                next_udp_port()
/// @throws base::ConfigError
LinkConfig parse_endpoint(const std::string& text, EndpointUse use = EndpointUse::kPlain,
                          std::span<const LinkConfig> before = {});

/// The first port from the usual one on (14550) for a link that sends to this host over UDP beside
/// those `before`: none of them sends there, or listens there on this machine.
/// @param host  an IPv6 address in brackets
unsigned next_udp_port(const std::string& host, std::span<const LinkConfig> before);

/// The rate of a serial endpoint without one; 0: of USB, which has none, or of a name that does not
/// tell. Follows symlinks, those of /dev/serial/by-id for example.
unsigned usual_baud(const std::string& device);

/// Whether a word of the command line is meant as an endpoint and not as a file.
bool is_endpoint(std::string_view text);

/// What a command line has casd record.
struct EndpointLog {
  std::string folder;      ///< of the autopilots' logs; empty: none
  bool telemetry = false;  ///< a telemetry log, too
};

/// What a command line says beside its endpoints.
struct EndpointOptions {
  int command_port = -1;  ///< below 0: the usual one
  bool silent = false;    ///< neither HEARTBEAT nor questions on sight
  EndpointLog log{};
};

/// A topology of these links, as a file's text: all to all, but no simulator's sensor data, which
/// would fly a vehicle in HIL; a bench has a topology of its own. Links without a name get one of
/// their type.
std::string topology_of_endpoints(std::vector<LinkConfig> links,
                                  const EndpointOptions& options = {});

/// What only a simulator says to a vehicle in HIL.
inline constexpr std::array<std::string_view, 6> kSimulatorMessages{
    "HIL_SENSOR",           "HIL_GPS",          "HIL_STATE",
    "HIL_STATE_QUATERNION", "HIL_OPTICAL_FLOW", "HIL_RC_INPUTS_RAW"};

/// In double quotes, whatever it holds.
std::string yaml_string(const std::string& text);

/// "57600" or "[57600, 921600]". @param rates  one at least
std::string baud_text(const std::vector<unsigned>& rates);

/// "- {name: ..., type: ..., ...}": what `parse_endpoint` sets, as an entry of `links`.
std::string link_entry(const LinkConfig& link);

}  // namespace cas::casd
