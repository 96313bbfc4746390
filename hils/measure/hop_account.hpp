// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/measure/ledger.hpp"
#include "casd/counters/link_ledger.hpp"
#include "hils/measure/packet_account.hpp"

namespace cas::hils {

/// What casd noted of the HIL packets at its two links.
struct RelayLedgers {
  casd::LinkLedger simulator;   ///< link "sim"
  casd::LinkLedger controller;  ///< link "fcu"
};

/// The four points that each HIL packet of one message passes, in the order of its way.
struct PacketPath {
  std::string message;  ///< "HIL_SENSOR"
  std::uint32_t message_id = 0;
  bool upwards = true;  ///< from the simulator to the controller
};

/// One hop of the way: from one point to the next.
struct HopFigures {
  std::string name;  ///< "simulator -> casd"
  std::uint64_t in = 0;
  std::uint64_t out = 0;
  DelayFigures delay{};
  double jitter_us = 0;  ///< mean change of the delay from one packet to the next
};

/// Where the packets of one message went, within a window of their own stamps.
struct PathAccount {
  std::string message;
  std::vector<HopFigures> hops{};                 ///< one from end to end where casd kept no ledger
  std::map<std::string, std::uint64_t> losses{};  ///< by cause, in words
  std::uint64_t sent = 0;
  std::uint64_t received = 0;
  std::string open{};  ///< why the account does not close; empty when it does

  bool closes() const { return open.empty(); }
};

/// Follows each packet from its sender through casd to its receiver. It must be received, or lost
/// at one place for one reason; anything else leaves the account open.
///
/// @param relay  nothing where casd kept no ledger: then only the ends are compared
PathAccount account_path(const PacketPath& path, std::span<const base::LedgerEntry> simulator,
                         std::span<const base::LedgerEntry> controller, const RelayLedgers* relay,
                         StreamWindow window);

/// The delays of each hop, ns, in the order of the stamps; for histograms.
std::vector<std::pair<std::string, std::vector<std::int64_t>>> hop_delays(
    const PacketPath& path, std::span<const base::LedgerEntry> simulator,
    std::span<const base::LedgerEntry> controller, const RelayLedgers* relay, StreamWindow window);

}  // namespace cas::hils
