// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "casd/packet/packet_info.hpp"
#include "casd/queue/tx_queue.hpp"

namespace cas::casd {

/// What happened to one HIL packet at a link. (message_id, time_usec) is its identity everywhere.
struct LinkLedgerEntry {
  std::uint32_t message_id = 0;
  DropCause cause{};            ///< of a dropped one
  std::uint64_t time_usec = 0;  ///< the packet's own stamp
  std::int64_t at_ns = 0;       ///< RunTime
};

/// Remembers each HIL packet that came from a link, was sent over it or dropped on the way to it.
/// The three are written in places that exclude each other only among their own kind, so each has a
/// list of its own; they are read when the link is at rest.
class LinkLedger {
 public:
  void received(const PacketInfo& info) {
    if (info.hil_time_usec != 0) add(received_, info, info.received, {});
  }
  void sent(const PacketInfo& info, base::RunTime at) {
    if (info.hil_time_usec != 0) add(sent_, info, at, {});
  }
  void dropped(const PacketInfo& info, DropCause cause, base::RunTime at) {
    if (info.hil_time_usec != 0) add(dropped_, info, at, cause);
  }

  using Entries = std::vector<LinkLedgerEntry>;
  const Entries& received() const { return received_; }
  const Entries& sent() const { return sent_; }
  const Entries& dropped() const { return dropped_; }

 private:
  friend std::map<std::string, LinkLedger> read_link_ledgers(const std::filesystem::path& file);

  static void add(Entries& entries, const PacketInfo& info, base::RunTime at, DropCause cause) {
    entries.push_back({info.message_id, cause, info.hil_time_usec, at.time_since_epoch().count()});
  }

  Entries received_;
  Entries sent_;
  Entries dropped_;
};

/// CSV with header "link,event,message_id,time_usec,at_ns"; event is received, sent or
/// dropped.CAUSE.
/// @throws base::ConfigError
void write_link_ledgers(const std::filesystem::path& file,
                        const std::map<std::string, const LinkLedger*>& ledgers);
/// @throws base::ConfigError
std::map<std::string, LinkLedger> read_link_ledgers(const std::filesystem::path& file);

}  // namespace cas::casd
