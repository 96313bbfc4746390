// SPDX-License-Identifier: BSD-3-Clause
#include "hils/measure/packet_account.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <deque>
#include <limits>
#include <string_view>

namespace cas::hils {

namespace {

using Direction = base::LedgerEntry::Direction;

/// The sender must outlive the window by this much of its own stamps before the pipe counts as
/// drained: more than any queue of the chain keeps a packet.
constexpr std::uint64_t kDrainUsec = 500'000;

/// First occurrence of each stamp: time_usec -> moment, in the order of the stamps.
using Moments = std::vector<std::pair<std::uint64_t, std::int64_t>>;

/// Puts moments in the order of their stamps. @return how many were left out, because a stamp came
/// again
std::uint64_t put_in_order(Moments& moments) {
  const auto stamp = &Moments::value_type::first;
  if (!std::ranges::is_sorted(moments, {}, stamp)) std::ranges::stable_sort(moments, {}, stamp);
  const auto same = [](const auto& a, const auto& b) { return a.first == b.first; };
  const auto again = std::unique(moments.begin(), moments.end(), same);
  const auto count = static_cast<std::uint64_t>(moments.end() - again);
  moments.erase(again, moments.end());
  return count;
}

/// Looks for stamps that are asked for in their order.
class Search {
 public:
  explicit Search(const Moments& moments) : at_(moments.begin()), end_(moments.end()) {}

  /// When it was; nullptr when it was not. @param stamp  not before the one asked for last
  const std::int64_t* find(std::uint64_t stamp) {
    while (at_ != end_ && at_->first < stamp) ++at_;
    return at_ != end_ && at_->first == stamp ? &at_->second : nullptr;
  }

 private:
  Moments::const_iterator at_;
  Moments::const_iterator end_;
};

constexpr StreamWindow kWhole{.begin_usec = 0, .end_usec = UINT64_MAX};

/// One point of the way, and how often a stamp came again.
struct Point {
  Moments moments;
  std::uint64_t repeated = 0;
  HopPoint place = HopPoint::kSimulator;

  std::string_view name() const {
    constexpr std::array<std::string_view, 4> kNames{"simulator", "casd in", "casd out",
                                                     "controller"};
    return kNames.at(static_cast<std::size_t>(place));
  }
};

Point point_of(std::span<const base::LedgerEntry> ledger, Direction direction,
               std::uint32_t message_id, StreamWindow window) {
  Point point;
  for (const base::LedgerEntry& entry : ledger) {
    if (entry.direction != direction || entry.message_id != message_id) continue;
    if (window.holds(entry.time_usec)) point.moments.emplace_back(entry.time_usec, entry.at_ns);
  }
  point.repeated = put_in_order(point.moments);
  return point;
}

Point point_of(const casd::LinkLedger::Entries& entries, std::uint32_t message_id,
               StreamWindow window) {
  Point point;
  for (const casd::LinkLedgerEntry& entry : entries) {
    if (entry.message_id != message_id || !window.holds(entry.time_usec)) continue;
    point.moments.emplace_back(entry.time_usec, entry.at_ns);
  }
  point.repeated = put_in_order(point.moments);
  return point;
}

Moments moments_of(const LedgerView& view, StreamWindow window = kWhole) {
  return point_of(view.ledger, view.direction, view.message_id, window).moments;
}

/// The rate of a stream that begins within the window counts from its begin: no earlier message is
/// missed. GPS begins up to a fifth of a second late by its own rate.
constexpr std::uint64_t kLatestBeginUsec = 500'000;

bool begins_late(const Moments& sent, StreamWindow window) {
  const auto early = [&](const auto& entry) {
    return entry.first <= window.begin_usec + kLatestBeginUsec;
  };
  return !sent.empty() && std::ranges::none_of(sent, early);
}

std::uint64_t last_stamp(std::span<const base::LedgerEntry> ledger) {
  std::uint64_t last = 0;
  for (const base::LedgerEntry& entry : ledger) {
    if (entry.direction == Direction::kSent) last = std::max(last, entry.time_usec);
  }
  return last;
}

/// Delays between equal stamps, in the order of the stamps.
std::vector<std::int64_t> delays_between(const Moments& from, const Moments& to) {
  std::vector<std::int64_t> delays;
  delays.reserve(to.size());
  Search departures(from);
  for (const auto& [stamp, arrived] : to) {
    if (const std::int64_t* departed = departures.find(stamp)) {
      delays.push_back(arrived - *departed);
    }
  }
  return delays;
}

double microseconds(std::int64_t ns) { return static_cast<double>(ns) / 1000.0; }

/// Why a packet is lost on a hop that has no ledger of its own.
std::string way_words(bool upwards, std::size_t hop, std::size_t hops) {
  if (hops == 1) return "somewhere on the way";
  const bool on_line = upwards == (hop == 2);
  return on_line ? "on the serial line" : "in the socket of the receiver";
}

std::string hop_name(const Point& from, const Point& to) {
  return fmt::format("{} -> {}", from.name(), to.name());
}

/// Time for which a hop stood still. Its first packet after a pause waited longest; those behind it
/// came later and waited less.
/// @param delays_ns  in the order of the stamps
double paused_ms(std::span<const std::int64_t> delays_ns) {
  constexpr std::int64_t kLeast_ns = 25'000'000;  // as long as casd keeps a HIL packet by default
  if (delays_ns.empty() || std::ranges::max(delays_ns) < kLeast_ns) return 0;
  const double median_us = summarise({delays_ns.begin(), delays_ns.end()}).p50;
  const auto usual_ns = static_cast<std::int64_t>(1e3 * median_us);
  std::int64_t sum_ns = 0;
  bool in_pause = false;
  for (const std::int64_t delay_ns : delays_ns) {
    const std::int64_t held_up_ns = delay_ns - usual_ns;
    if (held_up_ns >= kLeast_ns && !in_pause) sum_ns += held_up_ns;
    in_pause = held_up_ns >= kLeast_ns;
  }
  return 1e-6 * static_cast<double>(sum_ns);
}

HopFigures hop_between(const Point& from, const Point& to) {
  HopFigures hop{.from = from.place, .to = to.place, .name = hop_name(from, to)};
  hop.in = from.moments.size();
  std::vector<std::int64_t> delays = delays_between(from.moments, to.moments);
  hop.paused_ms = paused_ms(delays);
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
  const auto add = [&points](HopPoint place, Point point) {
    points.push_back(std::move(point));
    points.back().place = place;
  };
  add(up ? HopPoint::kSimulator : HopPoint::kController,
      point_of(up ? simulator : controller, Direction::kSent, path.message_id, window));
  if (relay != nullptr) {
    const casd::LinkLedger& in = up ? relay->simulator : relay->controller;
    const casd::LinkLedger& out = up ? relay->controller : relay->simulator;
    add(HopPoint::kCasdIn, point_of(in.received(), path.message_id, window));
    add(HopPoint::kCasdOut, point_of(out.sent(), path.message_id, window));
  }
  add(up ? HopPoint::kController : HopPoint::kSimulator,
      point_of(up ? controller : simulator, Direction::kReceived, path.message_id, window));
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
      account.open = fmt::format("{} packets passed twice at {}", point.repeated, point.name());
    }
    if (i == 0) continue;
    Search before(points[i - 1].moments);
    for (const auto& [stamp, moment] : point.moments) {
      if (before.find(stamp) == nullptr) {
        account.open = fmt::format("a packet came to {} that had not passed {}", point.name(),
                                   points[i - 1].name());
      }
    }
  }
}

/// Time at an edge of the window for which a stream is silent, less the period that it may be; 0
/// for up to three periods, which is jitter.
double silence_s(std::uint64_t gap_usec, double nominal_hz) {
  constexpr double kJitter = 3;  // periods
  const double period_s = 1 / nominal_hz;
  const double gap_s = static_cast<double>(gap_usec) * 1e-6;
  return gap_s > kJitter * period_s ? gap_s - period_s : 0;
}

/// Lag of a sent packet behind its stamp, to within a constant.
struct Lag {
  std::uint64_t time_usec;  // the stamp
  std::int64_t ns;
};

/// Largest rise of the lag within a second of the stream. A lag that is never made up counts once.
std::int64_t largest_rise_ns(std::span<const Lag> lags) {
  constexpr std::uint64_t kSpan_usec = 1'000'000;
  std::int64_t largest = 0;
  std::deque<Lag> least;  // candidates of the last second, in rising order: the first is the least
  for (const Lag& lag : lags) {
    while (!least.empty() && least.front().time_usec + kSpan_usec < lag.time_usec)
      least.pop_front();
    if (!least.empty()) largest = std::max(largest, lag.ns - least.front().ns);
    while (!least.empty() && least.back().ns >= lag.ns) least.pop_back();
    least.push_back(lag);
  }
  return largest;
}

}  // namespace

RateFigures account(std::span<const base::LedgerEntry> sender,
                    std::span<const base::LedgerEntry> receiver, std::uint32_t message_id,
                    StreamWindow window, double nominal_hz) {
  const Moments sent = moments_of({sender, Direction::kSent, message_id});
  RateFigures figures;
  figures.nominal_hz = nominal_hz;
  figures.sent = static_cast<std::uint64_t>(
      std::ranges::count_if(sent, [&](const auto& entry) { return window.holds(entry.first); }));
  figures.drained = last_stamp(sender) >= window.end_usec + kDrainUsec;
  figures.began_late = begins_late(sent, window);

  const Point arrivals = point_of(receiver, Direction::kReceived, message_id, window);
  const Moments& arrived = arrivals.moments;
  figures.duplicated = arrivals.repeated;
  std::int64_t first = std::numeric_limits<std::int64_t>::max();
  std::int64_t last = std::numeric_limits<std::int64_t>::min();
  Search departures(sent);
  for (const auto& [stamp, moment] : arrived) {
    if (departures.find(stamp) == nullptr) ++figures.unexplained;
    first = std::min(first, moment);
    last = std::max(last, moment);
  }
  figures.received = arrived.size() - figures.unexplained;
  figures.lost = figures.sent - figures.received;
  if (arrived.size() >= 2 && last > first) {
    // Packets lost at an edge of the window count like those between two others.
    const double silent_s = silence_s(arrived.front().first - window.begin_usec, nominal_hz) +
                            silence_s(window.end_usec - arrived.back().first, nominal_hz);
    figures.received_hz = static_cast<double>(arrived.size() - 1) /
                          (static_cast<double>(last - first) * 1e-9 + silent_s);
  }
  figures.error_pct = 100.0 * (nominal_hz - figures.received_hz) / nominal_hz;
  return figures;
}

DelayFigures summarise(std::vector<std::int64_t> delays_ns) {
  DelayFigures figures;
  if (delays_ns.empty()) return figures;
  auto at = [&, ordered = delays_ns.begin()](double q) mutable {  // nearest rank, q rises
    const auto n = static_cast<double>(delays_ns.size());
    const auto rank = static_cast<std::ptrdiff_t>(std::max(1.0, std::ceil(q * n)));
    const auto place = delays_ns.begin() + (rank - 1);
    if (place < ordered) return microseconds(*place);
    std::nth_element(ordered, place, delays_ns.end());
    ordered = place + 1;
    return microseconds(*place);
  };
  figures.count = delays_ns.size();
  figures.p50 = at(0.50);
  figures.p90 = at(0.90);
  figures.p99 = at(0.99);
  figures.max = at(1);
  return figures;
}

std::vector<std::int64_t> delays_ns(const LedgerView& from, const LedgerView& to,
                                    StreamWindow window) {
  return delays_between(moments_of(from, window), moments_of(to, window));
}

std::vector<std::int64_t> echo_delays_ns(std::span<const base::LedgerEntry> ledger,
                                         std::uint32_t sensor_id, std::uint32_t controls_id,
                                         StreamWindow window) {
  return delays_ns({ledger, Direction::kSent, sensor_id},
                   {ledger, Direction::kReceived, controls_id}, window);
}

std::vector<std::int64_t> hop_delays_ns(std::span<const base::LedgerEntry> sender,
                                        std::span<const base::LedgerEntry> receiver,
                                        std::uint32_t message_id, StreamWindow window) {
  return delays_ns({sender, Direction::kSent, message_id},
                   {receiver, Direction::kReceived, message_id}, window);
}

PaceFigures pace(std::span<const base::LedgerEntry> sender, std::uint32_t message_id,
                 StreamWindow window) {
  PaceFigures figures;
  std::vector<Lag> lags;
  const base::LedgerEntry* first = nullptr;
  const base::LedgerEntry* last = nullptr;
  for (const base::LedgerEntry& entry : sender) {
    if (entry.direction != Direction::kSent || entry.message_id != message_id) continue;
    if (!window.holds(entry.time_usec)) continue;
    if (first == nullptr) first = &entry;
    last = &entry;
    lags.push_back(
        {entry.time_usec, entry.at_ns - static_cast<std::int64_t>(entry.time_usec) * 1000});
  }
  if (first == nullptr || last->at_ns <= first->at_ns) return figures;
  figures.real_time_factor = static_cast<double>(last->time_usec - first->time_usec) * 1000.0 /
                             static_cast<double>(last->at_ns - first->at_ns);
  const std::int64_t least = std::ranges::min(lags, {}, &Lag::ns).ns;
  std::vector<std::int64_t> behind_ns;
  for (const Lag& lag : lags) behind_ns.push_back(lag.ns - least);
  figures.worst_stall_ms = 1e-6 * static_cast<double>(largest_rise_ns(lags));
  figures.late_p99_ms = 1e-3 * summarise(std::move(behind_ns)).p99;
  return figures;
}

double averaging_meter_hz(std::span<const std::int64_t> arrivals_ns, std::int64_t until_ns) {
  constexpr std::int64_t kPeriodNs = 1'000'000'000;
  constexpr double kGain = 0.2;
  if (arrivals_ns.empty()) return 0;
  double shown_hz = 0;
  std::size_t next = 1;
  for (std::int64_t end = arrivals_ns.front() + kPeriodNs; end <= until_ns; end += kPeriodNs) {
    std::size_t count = 0;
    for (; next < arrivals_ns.size() && arrivals_ns[next] <= end; ++next) ++count;
    shown_hz += kGain * (static_cast<double>(count) - shown_hz);
  }
  return shown_hz;
}

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
  std::vector<Search> next;
  for (std::size_t i = 1; i <= hops; ++i) next.emplace_back(points[i].moments);
  for (const auto& [stamp, moment] : points.front().moments) {
    std::size_t reached = 0;
    while (reached < hops && next[reached].find(stamp) != nullptr) ++reached;
    const auto drop = drops.find(stamp);
    const bool in_casd = hops == 3 && reached == 1;
    if (reached == hops) {
      ++account.received;
    } else if (!in_casd) {
      ++account.losses[way_words(path.upwards, reached, hops)];
    } else if (drop != drops.end()) {
      ++account.losses[std::string(words_of(drop->second).account)];
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
    hops.emplace_back(hop_name(points[i], points[i + 1]),
                      delays_between(points[i].moments, points[i + 1].moments));
  }
  return hops;
}

}  // namespace cas::hils
