// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <optional>
#include <string_view>

#include "casd/words/drop_cause.hpp"

namespace cas::casd {

/// A counter of a link as shown everywhere: in JSON, to Prometheus, and by `casctl status`,
/// `monitor`, `drops` and `doctor`.
struct CounterWords {
  enum class Kind { kTotal, kGauge, kByCause };

  std::string_view group;  ///< block of the link's JSON, "rx" or "tx"; empty: of the link itself
  std::string_view key;    ///< in that block; casd_link_GROUP_KEY_total for Prometheus
  std::string_view help;
  std::string_view column{};  ///< of `casctl status`; empty: not shown there
  Kind kind = Kind::kTotal;
  std::string_view narrow{};  ///< column of the monitor; empty: not shown there
  int rank = 0;               ///< of that column: those of a higher rank go first for lack of room
  /// In link.drops; nullopt: packets that count here are not dropped.
  std::optional<DropCause> cause{};
  std::string_view trouble{};  ///< the doctor's text when it grows; empty: none
  std::string_view remedy{};
  bool bad = false;  ///< trouble that stops a run, not only a warning
};

inline constexpr auto kLinkCounters = std::to_array<CounterWords>({
    {"rx", "packets", "Packets received.", "RX"},
    {"rx", "bytes", "Bytes received."},
    {.group = "rx",
     .key = "lost",
     .help = "Gaps in the sequence numbers of senders.",
     .column = "LOST",
     .narrow = "LOST",
     .rank = 4,
     .trouble = "packets are lost before they reach casd",
     .remedy = "the sender has more than the line carries: lower its rates or raise the baud rate"},
    {.group = "rx",
     .key = "crc_errors",
     .help = "Packets with a wrong checksum.",
     .column = "CRC",
     .narrow = "CRC",
     .rank = 6,
     .cause = DropCause::kCrc,
     .trouble = "packets arrive damaged",
     .remedy = "check cable, ground and baud rate at both ends; use flow control where there is "
               "one"},
    {"rx", "unknown", "Packets whose message no public dialect has."},
    {"rx", "skipped_bytes", "Bytes that were part of no packet."},
    {.group = "rx",
     .key = "kernel_drops",
     .help = "Datagrams that the socket's buffer lost.",
     .cause = DropCause::kKernel,
     .trouble = "the socket buffer overflows",
     .remedy = "sysctl -w net.core.rmem_max=4194304, then restart casd",
     .bad = true},
    {.group = "rx",
     .key = "foreign",
     .help = "Datagrams from somebody else than the peer.",
     .cause = DropCause::kForeign},
    {.group = "rx",
     .key = "not_accepted",
     .help = "Packets that the link's accept leaves out.",
     .cause = DropCause::kNotAccepted},
    {.group = "rx",
     .key = "no_memory",
     .help = "Packets that a destination did not get because casd got no memory.",
     .cause = DropCause::kNoMemory,
     .trouble = "casd gets no memory",
     .remedy = "give it more (MemoryMax of the service, ulimit -v), or end what takes it",
     .bad = true},
    {"tx", "packets", "Packets sent.", "TX"},
    {"tx", "bytes", "Bytes sent."},
    {"tx", "dropped", "Packets dropped before sending.", "DROPPED", CounterWords::Kind::kByCause,
     "DROP", 5},
    {"tx", "refused",
     "Packets sent to a UDP destination that refused them, as far as the kernel says.", "REFUSED"},
    {"tx", "queued", "Packets that wait for the link.", "", CounterWords::Kind::kGauge},
    {"tx", "queue_high_water", "Most packets that ever waited.", "QUEUE",
     CounterWords::Kind::kGauge, "QMAX", 8},
    {"tx", "write_calls", "System calls that sent."},
    {"", "reconnects", "How often the link came back.", "RECONNECTS"},
    {"", "uncounted", "Packets that casd_messages_total had no room for."},
});

/// The row of a counter; its name is wrong where this does not compile.
consteval const CounterWords& counter_words(std::string_view group, std::string_view key) {
  for (const CounterWords& words : kLinkCounters) {
    if (words.group == group && words.key == key) return words;
  }
  throw "no such counter";
}

}  // namespace cas::casd
