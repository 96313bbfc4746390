// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/os/thread.hpp"
#include "base/time/clock.hpp"
#include "casd/packet/link_id.hpp"
#include "casd/packet/message_rate.hpp"
#include "casd/queue/tx_queue.hpp"
#include "casd/routing/routing_rules.hpp"

namespace cas::base {
class ConfigNode;
struct KeyRow;
}  // namespace cas::base

namespace cas::casd {

/// MAVLink 2 signing of a link (`signing`).
struct SigningConfig {
  std::filesystem::path key_file;
  std::uint8_t link_id = 0;  ///< distinguishes the links of one key
  bool verify = true;        ///< refuse packets not signed with the key, take signatures off
  bool sign = true;          ///< sign what goes out
  std::vector<std::uint32_t> allow_unsigned;  ///< messages that may come unsigned
  /// How far ahead of casd's clock a signed packet may be; 0: any
  base::Duration max_future = std::chrono::hours(24);

  friend bool operator==(const SigningConfig&, const SigningConfig&) = default;
};

/// What may pass from a link to vehicles that do not say that they are in HIL.
enum class ToNotHil : std::uint8_t { kAll, kStopsOnly };

/// One entry of `links`. Keys that a type does not have are refused.
struct LinkConfig {
  std::string name;
  LinkType type = LinkType::kUdp;

  // udp, udp_server, tcp, tcp_server: "HOST:PORT", "[V6]:PORT"; a host may be a name
  std::string local;      ///< udp: optional; servers: where they listen
  std::string remote;     ///< udp, tcp: the peer; broadcast and multicast addresses are allowed
  std::string interface;  ///< network device to bind to; empty: any
  int max_peers = 64;     ///< servers: peers at one time
  base::Duration expiry = std::chrono::seconds(30);  ///< udp_server: silence that ends a peer

  // serial
  std::string device;           ///< path, usually a udev or symlink name; ${NAME} is replaced
  std::vector<unsigned> baud;   ///< tried in turn; empty: USB, no rate of its own
  bool flow_control = false;    ///< RTS/CTS
  bool pace = true;             ///< hold writes to 98 % of the baud rate
  base::Duration sensor_gap{};  ///< least time between two HIL_SENSOR; 0: none
  bool pace_pty = false;      ///< also on a pseudo-terminal: configured, or its routes may fill it
  bool unlocked_pty = false;  ///< also takes a pseudo-terminal whose owner holds no lock

  // tlog
  std::filesystem::path file;
  double speed = 1;       ///< recorded seconds per second
  bool repeat = false;    ///< from the start again at its end
  bool commands = false;  ///< plays what ground stations said, too

  // all
  double max_bytes_s = 0;                  ///< cap on sent bytes; 0: none
  bool pass_unknown = false;               ///< let packets with unknown message ids pass
  std::string group;                       ///< redundant paths share a group name
  bool inject_failures = false;            ///< stations here may inject failures into the simulator
  bool sniffer = false;                    ///< gets every packet, for any target; takes in nothing
  std::vector<MessageRate> request_rates;  ///< requested from vehicles heard here
  ToNotHil to_not_hil = ToNotHil::kAll;    ///< kStopsOnly: what may spin or move is held back
  AcceptRule accept;
  std::optional<SigningConfig> signing;
  TxQueueOptions queue;
  base::ThreadOptions scheduling;  ///< of the link's thread (threads: auto, per_link)

  /// Equal configurations keep their link over a reload.
  friend bool operator==(const LinkConfig&, const LinkConfig&) = default;
};

/// Whether several peers share the link.
inline bool is_server(const LinkConfig& link) {
  return link.type == LinkType::kUdpServer || link.type == LinkType::kTcpServer;
}

/// The link of that name; nullptr: there is none.
const LinkConfig* find_link(const std::vector<LinkConfig>& links, std::string_view name);

/// The lowest rate of a line; 0: it has none, or the link is not serial.
unsigned lowest_baud(const LinkConfig& link);

/// "57600 or 921600".
std::string words_of_rates(const std::vector<unsigned>& baud);

/// One entry of `links`. @throws base::ConfigError
LinkConfig parse_link(const base::ConfigNode& node);

/// The keys of a link whose value is not the default, "queue.hil_max_age_ms 64".
std::vector<std::string> changed_keys(const LinkConfig& link);

/// Keys of a link of that type, those of every link left out; without a type those of every link.
std::vector<base::KeyRow> link_rows(std::optional<LinkType> type);

}  // namespace cas::casd
