// SPDX-License-Identifier: BSD-3-Clause
#include "hils/measure/hop_account.hpp"

#include <cmath>
#include <cstdlib>
#include <string_view>

namespace cas::hils {

namespace {

using Direction = base::LedgerEntry::Direction;

/// One point of the way: stamp -> moment, and how often a stamp came again.
struct Point {
  std::string name;
  std::map<std::uint64_t, std::int64_t> moments;
  std::uint64_t repeated = 0;

  void add(std::uint64_t stamp, std::int64_t at_ns, StreamWindow window) {
    if (!window.holds(stamp)) return;
    if (!moments.try_emplace(stamp, at_ns).second) ++repeated;
  }
};

Point point_of(std::string name, std::span<const base::LedgerEntry> ledger, Direction direction,
               std::uint32_t message_id, StreamWindow window) {
  Point point{.name = std::move(name), .moments = {}};
  for (const base::LedgerEntry& entry : ledger) {
    if (entry.direction != direction || entry.message_id != message_id) continue;
    point.add(entry.time_usec, entry.at_ns, window);
  }
  return point;
}

Point point_of(std::string name, const casd::LinkLedger::Entries& entries, std::uint32_t message_id,
               StreamWindow window) {
  Point point{.name = std::move(name), .moments = {}};
  for (const casd::LinkLedgerEntry& entry : entries) {
    if (entry.message_id == message_id) point.add(entry.time_usec, entry.at_ns, window);
  }
  return point;
}

std::string drop_words(casd::DropCause cause) {
  switch (cause) {
    case casd::DropCause::kAge:
      return "too old in casd's queue";
    case casd::DropCause::kBandwidth:
      return "too old in casd's queue, under the link's max_bytes_s";
    case casd::DropCause::kQueueFull:
      return "casd's queue was full";
    case casd::DropCause::kClosed:
      return "the link was down";
    case casd::DropCause::kStalled:
      return "the peer stopped reading";
    case casd::DropCause::kUnsignable:
      return "casd could not sign it";
  }
  return "?";
}

/// Why a packet is lost on a hop that has no ledger of its own.
std::string way_words(bool upwards, std::size_t hop, std::size_t hops) {
  if (hops == 1) return "somewhere on the way";
  const bool on_line = upwards == (hop == 2);
  return on_line ? "on the serial line" : "in the socket of the receiver";
}

std::string hop_name(const Point& from, const Point& to) { return from.name + " -> " + to.name; }

std::vector<std::int64_t> delays_between(const Point& from, const Point& to) {
  std::vector<std::int64_t> delays;
  for (const auto& [stamp, arrived] : to.moments) {
    const auto departed = from.moments.find(stamp);
    if (departed != from.moments.end()) delays.push_back(arrived - departed->second);
  }
  return delays;
}

HopFigures hop_between(const Point& from, const Point& to) {
  HopFigures hop{.name = hop_name(from, to)};
  hop.in = from.moments.size();
  std::vector<std::int64_t> delays = delays_between(from, to);
  double change = 0;
  for (std::size_t i = 1; i < delays.size(); ++i) {
    change += std::abs(static_cast<double>(delays[i] - delays[i - 1]));
  }
  hop.out = delays.size();
  if (delays.size() > 1) hop.jitter_us = 1e-3 * change / static_cast<double>(delays.size() - 1);
  hop.delay = summarise(std::move(delays));
  return hop;
}

std::vector<Point> points_of(const PacketPath& path, std::span<const base::LedgerEntry> simulator,
                             std::span<const base::LedgerEntry> controller,
                             const RelayLedgers* relay, StreamWindow window) {
  const bool up = path.upwards;
  std::vector<Point> points;
  points.push_back(point_of(up ? "simulator" : "controller", up ? simulator : controller,
                            Direction::kSent, path.message_id, window));
  if (relay != nullptr) {
    const casd::LinkLedger& in = up ? relay->simulator : relay->controller;
    const casd::LinkLedger& out = up ? relay->controller : relay->simulator;
    points.push_back(point_of("casd in", in.received(), path.message_id, window));
    points.push_back(point_of("casd out", out.sent(), path.message_id, window));
  }
  points.push_back(point_of(up ? "controller" : "simulator", up ? controller : simulator,
                            Direction::kReceived, path.message_id, window));
  return points;
}

std::map<std::uint64_t, casd::DropCause> drops_of(const PacketPath& path, const RelayLedgers* relay,
                                                  StreamWindow window) {
  std::map<std::uint64_t, casd::DropCause> drops;
  if (relay == nullptr) return drops;
  const casd::LinkLedger& out = path.upwards ? relay->controller : relay->simulator;
  for (const casd::LinkLedgerEntry& entry : out.dropped()) {
    if (entry.message_id == path.message_id && window.holds(entry.time_usec)) {
      drops[entry.time_usec] = entry.cause;
    }
  }
  return drops;
}

void check_points(const std::vector<Point>& points, PathAccount& account) {
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Point& point = points[i];
    if (point.repeated > 0) {
      account.open = std::to_string(point.repeated) + " packets passed twice at " + point.name;
    }
    if (i == 0) continue;
    for (const auto& [stamp, moment] : point.moments) {
      if (!points[i - 1].moments.contains(stamp)) {
        account.open =
            "a packet came to " + point.name + " that had not passed " + points[i - 1].name;
      }
    }
  }
}

}  // namespace

PathAccount account_path(const PacketPath& path, std::span<const base::LedgerEntry> simulator,
                         std::span<const base::LedgerEntry> controller, const RelayLedgers* relay,
                         StreamWindow window) {
  const std::vector<Point> points = points_of(path, simulator, controller, relay, window);
  const std::map<std::uint64_t, casd::DropCause> drops = drops_of(path, relay, window);
  const std::size_t hops = points.size() - 1;
  PathAccount account{.message = path.message};
  check_points(points, account);
  for (std::size_t i = 0; i < hops; ++i) {
    account.hops.push_back(hop_between(points[i], points[i + 1]));
  }
  account.sent = points.front().moments.size();
  for (const auto& [stamp, moment] : points.front().moments) {
    std::size_t reached = 0;
    while (reached < hops && points[reached + 1].moments.contains(stamp)) ++reached;
    const auto drop = drops.find(stamp);
    const bool in_casd = hops == 3 && reached == 1;
    if (reached == hops) {
      ++account.received;
    } else if (!in_casd) {
      ++account.losses[way_words(path.upwards, reached, hops)];
    } else if (drop != drops.end()) {
      ++account.losses[drop_words(drop->second)];
    } else {
      account.open = "a packet came into casd and neither left it nor was dropped";
    }
  }
  return account;
}

std::vector<std::pair<std::string, std::vector<std::int64_t>>> hop_delays(
    const PacketPath& path, std::span<const base::LedgerEntry> simulator,
    std::span<const base::LedgerEntry> controller, const RelayLedgers* relay, StreamWindow window) {
  const std::vector<Point> points = points_of(path, simulator, controller, relay, window);
  std::vector<std::pair<std::string, std::vector<std::int64_t>>> hops;
  for (std::size_t i = 0; i + 1 < points.size(); ++i) {
    hops.emplace_back(hop_name(points[i], points[i + 1]), delays_between(points[i], points[i + 1]));
  }
  return hops;
}

}  // namespace cas::hils
