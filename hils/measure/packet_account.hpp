// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/measure/ledger.hpp"
#include "casd/counters/link_ledger.hpp"

namespace cas::hils {

/// A stretch of the stream by the packets' own stamps, both ends included.
struct StreamWindow {
  std::uint64_t begin_usec = 0;
  std::uint64_t end_usec = 0;
  bool holds(std::uint64_t time_usec) const {
    return time_usec >= begin_usec && time_usec <= end_usec;
  }
};

/// One HIL message from its sender to its receiver, within a window.
struct RateFigures {
  double nominal_hz = 0;
  std::uint64_t sent = 0;
  std::uint64_t received = 0;
  std::uint64_t lost = 0;
  /// (n - 1) / (t_last - t_first) by the receiver's clock; the silence at an edge of the window,
  /// by stamps, makes that time longer.
  double received_hz = 0;
  double error_pct = 0;  ///< how far received_hz falls short of nominal; negative above it

  std::uint64_t duplicated = 0;   ///< identities that arrived more than once
  std::uint64_t unexplained = 0;  ///< identities that arrived and were never sent
  bool drained = false;     ///< the sender went on long enough for the window's packets to arrive
  bool began_late = false;  ///< the sender began over half a second after the window

  /// Every packet is sent and then received once or lost; nothing else arrived.
  bool closes() const { return duplicated == 0 && unexplained == 0 && drained && !began_late; }
};

/// Follows `message_id` by (message id, time_usec) from the sender's ledger to the receiver's.
RateFigures account(std::span<const base::LedgerEntry> sender,
                    std::span<const base::LedgerEntry> receiver, std::uint32_t message_id,
                    StreamWindow window, double nominal_hz);

/// Order statistics of a set of delays, microseconds.
struct DelayFigures {
  std::uint64_t count = 0;
  double p50 = 0;
  double p90 = 0;
  double p99 = 0;
  double max = 0;
};
DelayFigures summarise(std::vector<std::int64_t> delays_ns);

/// One message in one direction at one end.
struct LedgerView {
  std::span<const base::LedgerEntry> ledger;
  base::LedgerEntry::Direction direction;
  std::uint32_t message_id;
};
/// Delays between equal stamps of two views, ns, in the order of the stamps; both on one clock.
std::vector<std::int64_t> delays_ns(const LedgerView& from, const LedgerView& to,
                                    StreamWindow window);

/// Delays from sending `sensor_id` to receiving the `controls_id` that echoes its stamp, by one
/// program's ledger, ns, in the order of the stamps.
std::vector<std::int64_t> echo_delays_ns(std::span<const base::LedgerEntry> ledger,
                                         std::uint32_t sensor_id, std::uint32_t controls_id,
                                         StreamWindow window);

/// Delays from the sender's ledger to the receiver's of one message, ns; both on one clock.
std::vector<std::int64_t> hop_delays_ns(std::span<const base::LedgerEntry> sender,
                                        std::span<const base::LedgerEntry> receiver,
                                        std::uint32_t message_id, StreamWindow window);

/// How well the sender kept to real time.
struct PaceFigures {
  double real_time_factor = 0;  ///< simulated over elapsed time in the window
  double worst_stall_ms = 0;    ///< largest rise of its lag within a second
  double late_p99_ms = 0;       ///< 99 % of the stream fell behind its own stamps by less
};
PaceFigures pace(std::span<const base::LedgerEntry> sender, std::uint32_t message_id,
                 StreamWindow window);

/// Reading of the message inspector of QGroundControl 3, the instrument of [HILS] Table 4: it
/// counts in periods of one second and shows an exponential mean with gain 0.2 that starts at zero;
/// the first message is not counted. A true 500 Hz reads 446 after 10 s.
///
/// @param arrivals_ns  moments of arrival, in order
/// @param until_ns     moment of reading
double averaging_meter_hz(std::span<const std::int64_t> arrivals_ns, std::int64_t until_ns);

/// casd's ledgers of the HIL packets at its two links.
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

/// A point that each HIL packet passes.
enum class HopPoint { kSimulator, kCasdIn, kCasdOut, kController };

/// One hop of the way: from one point to the next.
struct HopFigures {
  HopPoint from = HopPoint::kSimulator;
  HopPoint to = HopPoint::kController;
  std::string name{};  ///< of both, for people: "simulator -> casd in"
  std::uint64_t in = 0;
  std::uint64_t out = 0;
  DelayFigures delay{};
  double jitter_us = 0;  ///< mean change of the delay from one packet to the next
  double paused_ms = 0;  ///< sum of its pauses, each as long as its first packet was held up
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
