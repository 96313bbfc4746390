// SPDX-License-Identifier: BSD-3-Clause
#include "hils/replay/hop_record.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <deque>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "mavlink/common/hil_gps.hpp"
#include "mavlink/common/hil_sensor.hpp"

namespace cas::hils {

namespace {

using OrderedJson = nlohmann::ordered_json;
using Direction = base::LedgerEntry::Direction;
using mavlink::common::HilGps;
using mavlink::common::HilSensor;

constexpr std::uint64_t kBinUsec = 1'000'000;
constexpr std::uint64_t kTapePeriodUsec = 4'000'000;
constexpr std::int64_t kTapeNs = 20'000'000;

/// A packet of one message passes a point: stamp -> moment, ns.
using Passings = std::unordered_map<std::uint64_t, std::int64_t>;

Passings passings(const std::vector<base::LedgerEntry>& ledger, Direction direction,
                  std::uint32_t message_id) {
  Passings found;
  for (const base::LedgerEntry& entry : ledger) {
    if (entry.direction == direction && entry.message_id == message_id) {
      found.try_emplace(entry.time_usec, entry.at_ns);
    }
  }
  return found;
}

Passings passings(const casd::LinkLedger::Entries& entries, std::uint32_t message_id) {
  Passings found;
  for (const casd::LinkLedgerEntry& entry : entries) {
    if (entry.message_id == message_id) found.try_emplace(entry.time_usec, entry.at_ns);
  }
  return found;
}

/// One message on one hop.
struct Stretch {
  std::uint32_t message_id = 0;
  std::string message;
  const Passings& from;
  const Passings& to;
};

/// A hop, or casd between its two links; the first stretch is the one whose delays are shown.
struct Hop {
  std::string from;
  std::string to;
  std::vector<Stretch> stretches;
};

struct Hops {
  std::vector<Hop> wires;
  std::vector<Hop> relay;
  std::deque<Passings> points;  ///< that the hops lie between
};

Hops hops_of(const RunRecord& record) {
  const std::uint32_t controls = controls_message_id(record);
  const std::string controls_name = controls == 91 ? "HIL_CONTROLS" : "HIL_ACTUATOR_CONTROLS";
  const bool relayed = record.relay.has_value();
  Hops hops;
  const auto keep = [&hops](Passings found) -> const Passings& {
    return hops.points.emplace_back(std::move(found));
  };
  const auto add = [](std::vector<Hop>& list, std::string from, std::string to,
                      std::vector<Stretch> stretches) {
    list.push_back({std::move(from), std::move(to), std::move(stretches)});
  };
  std::vector<Stretch> up_first;
  std::vector<Stretch> up_casd;
  std::vector<Stretch> up_last;
  for (const auto& [id, name] :
       {std::pair<std::uint32_t, std::string>{HilSensor::kId, "HIL_SENSOR"},
        std::pair<std::uint32_t, std::string>{HilGps::kId, "HIL_GPS"}}) {
    const Passings& sent = keep(passings(record.simulator, Direction::kSent, id));
    const Passings& received = keep(passings(record.controller, Direction::kReceived, id));
    if (!relayed) {
      up_first.push_back({id, name, sent, received});
      continue;
    }
    const Passings& in = keep(passings(record.relay->simulator.received(), id));
    const Passings& out = keep(passings(record.relay->controller.sent(), id));
    up_first.push_back({id, name, sent, in});
    up_casd.push_back({id, name, in, out});
    up_last.push_back({id, name, out, received});
  }
  const Passings& answered = keep(passings(record.controller, Direction::kSent, controls));
  const Passings& used = keep(passings(record.simulator, Direction::kReceived, controls));
  if (!relayed) {
    add(hops.wires, "sim", "fcu", std::move(up_first));
    add(hops.wires, "fcu", "sim", {{controls, controls_name, answered, used}});
    return hops;
  }
  const Passings& in = keep(passings(record.relay->controller.received(), controls));
  const Passings& out = keep(passings(record.relay->simulator.sent(), controls));
  add(hops.wires, "sim", "casd", std::move(up_first));
  add(hops.wires, "casd", "fcu", std::move(up_last));
  add(hops.wires, "fcu", "casd", {{controls, controls_name, answered, in}});
  add(hops.wires, "casd", "sim", {{controls, controls_name, out, used}});
  add(hops.relay, "sim", "fcu", std::move(up_casd));
  add(hops.relay, "fcu", "sim", {{controls, controls_name, in, out}});
  return hops;
}

/// Figures of one second of a hop.
struct Bin {
  std::uint64_t left = 0;
  std::uint64_t arrived = 0;
  std::vector<std::int64_t> delays_ns;
};

std::map<std::uint64_t, Bin> bins_of(const Stretch& stretch) {
  std::map<std::uint64_t, Bin> bins;
  for (const auto& [stamp, left_ns] : stretch.from) {
    Bin& bin = bins[stamp / kBinUsec];
    ++bin.left;
    const auto arrived = stretch.to.find(stamp);
    if (arrived == stretch.to.end()) continue;
    ++bin.arrived;
    bin.delays_ns.push_back(arrived->second - left_ns);
  }
  return bins;
}

/// Tenths of a microsecond are more than any clock here tells.
double rounded_us(double us) { return std::round(us * 10) / 10; }

/// [second, left, arrived, median us, 99 % us]
OrderedJson bins_json(const Stretch& stretch, bool with_delays) {
  OrderedJson rows = OrderedJson::array();
  for (auto& [second, bin] : bins_of(stretch)) {
    const DelayFigures delay = summarise(bin.delays_ns);
    OrderedJson row{second, bin.left, bin.arrived};
    if (with_delays && delay.count > 0) {
      row.push_back(rounded_us(delay.p50));
      row.push_back(rounded_us(delay.p99));
    }
    rows.push_back(std::move(row));
  }
  return rows;
}

OrderedJson hops_json(const std::vector<Hop>& hops, bool with_delays) {
  OrderedJson list = OrderedJson::array();
  for (const Hop& hop : hops) {
    OrderedJson messages = OrderedJson::array();
    for (const Stretch& stretch : hop.stretches) {
      if (stretch.from.empty()) continue;
      messages.push_back({{"id", stretch.message_id},
                          {"name", stretch.message},
                          {"bins", bins_json(stretch, with_delays)}});
    }
    list.push_back({{"from", hop.from},
                    {"to", hop.to},
                    {"measured", with_delays ? "stamps" : "none"},
                    {"messages", std::move(messages)}});
  }
  return list;
}

/// From a sensor message to the control that echoes its stamp: [second, answers, median, 99 %,
/// longest].
OrderedJson loop_json(const RunRecord& record) {
  const Passings sent = passings(record.simulator, Direction::kSent, HilSensor::kId);
  const Passings answered =
      passings(record.simulator, Direction::kReceived, controls_message_id(record));
  const Stretch loop{.message_id = HilSensor::kId, .message = "loop", .from = sent, .to = answered};
  OrderedJson rows = OrderedJson::array();
  for (auto& [second, bin] : bins_of(loop)) {
    const DelayFigures delay = summarise(bin.delays_ns);
    if (delay.count == 0) continue;
    rows.push_back(
        {second, delay.count, rounded_us(delay.p50), rounded_us(delay.p99), rounded_us(delay.max)});
  }
  return rows;
}

/// First stamp of each period of the tapes, and of each second in which a hop lost something.
std::set<std::pair<std::uint64_t, bool>> tape_begins(const std::vector<Hop>& hops) {
  constexpr std::size_t kMostLosses = 60;  // tapes; a flight that loses all the time looks alike
  constexpr std::uint64_t kBeforeUsec = 8'000;
  std::set<std::pair<std::uint64_t, bool>> begins;  // stamp, around a loss
  const Passings& sensors = hops.front().stretches.front().from;
  std::uint64_t last = 0;
  for (const auto& [stamp, moment] : sensors) last = std::max(last, stamp);
  for (std::uint64_t stamp = 0; stamp < last; stamp += kTapePeriodUsec)
    begins.insert({stamp, false});
  std::map<std::uint64_t, std::uint64_t> losses;  // second -> first stamp that was lost in it
  for (const Hop& hop : hops) {
    for (const Stretch& stretch : hop.stretches) {
      for (const auto& [stamp, moment] : stretch.from) {
        if (stretch.to.contains(stamp) || stamp + kBinUsec / 2 > last) continue;  // still under way
        const auto [first, is_new] = losses.try_emplace(stamp / kBinUsec, stamp);
        if (!is_new) first->second = std::min(first->second, stamp);
      }
    }
  }
  for (const auto& [second, stamp] : losses) {
    if (begins.size() > last / kTapePeriodUsec + kMostLosses) break;
    begins.insert({stamp > kBeforeUsec ? stamp - kBeforeUsec : 0, true});
  }
  return begins;
}

/// One packet on a hop: the moments at which it leaves and arrives, nothing where it is lost.
struct Travel {
  std::int64_t left_ns = 0;
  std::int64_t message_id = 0;
  std::optional<std::int64_t> arrived_ns;
};

/// All packets of a hop in the order in which they leave.
std::vector<Travel> travels_of(const Hop& hop) {
  std::vector<Travel> travels;
  for (const Stretch& stretch : hop.stretches) {
    for (const auto& [stamp, left_ns] : stretch.from) {
      Travel travel{.left_ns = left_ns, .message_id = stretch.message_id, .arrived_ns = {}};
      const auto arrived = stretch.to.find(stamp);
      if (arrived != stretch.to.end()) travel.arrived_ns = arrived->second;
      travels.push_back(travel);
    }
  }
  std::ranges::sort(travels, {}, [](const Travel& travel) {
    return std::pair(travel.left_ns, travel.message_id);
  });
  return travels;
}

/// Packets that leave within a tape: [message id, us after its begin, us on the way].
OrderedJson tape_json(const std::vector<Travel>& travels, std::int64_t begin_ns) {
  OrderedJson packets = OrderedJson::array();
  auto travel = std::ranges::lower_bound(travels, begin_ns, {}, &Travel::left_ns);
  for (; travel != travels.end() && travel->left_ns - begin_ns < kTapeNs; ++travel) {
    const std::int64_t after_us = (travel->left_ns - begin_ns) / 1000;
    if (travel->arrived_ns) {
      const std::int64_t on_way_us = (*travel->arrived_ns - travel->left_ns) / 1000;
      packets.push_back({travel->message_id, after_us, on_way_us});
    } else {
      packets.push_back({-travel->message_id, after_us, 0});
    }
  }
  return packets;
}

OrderedJson tapes_json(const std::vector<Hop>& hops) {
  std::vector<std::vector<Travel>> travels;
  travels.reserve(hops.size());
  for (const Hop& hop : hops) travels.push_back(travels_of(hop));
  const Passings& stamps = hops.front().stretches.front().from;
  std::vector<std::pair<std::uint64_t, std::int64_t>> sensors(stamps.begin(), stamps.end());
  std::ranges::sort(sensors);
  OrderedJson tapes = OrderedJson::array();
  for (const auto& [begin, around_loss] : tape_begins(hops)) {
    const auto first = std::ranges::lower_bound(sensors, begin, {},
                                                &std::pair<std::uint64_t, std::int64_t>::first);
    if (first == sensors.end()) continue;
    OrderedJson by_hop = OrderedJson::object();
    for (std::size_t i = 0; i < hops.size(); ++i) {
      by_hop[hops[i].from + ">" + hops[i].to] = tape_json(travels[i], first->second);
    }
    tapes.push_back({{"t_s", static_cast<double>(first->first) * 1e-6},
                     {"ms", kTapeNs / 1'000'000},
                     {"around", around_loss ? "loss" : "now"},
                     {"hops", std::move(by_hop)}});
  }
  return tapes;
}

}  // namespace

OrderedJson hop_record(const RunRecord& record) {
  if (record.simulator.empty()) return nullptr;
  const bool with_delays = !record.from_device && !record.foreign_stamps;
  const Hops hops = hops_of(record);
  return {{"hops", hops_json(hops.wires, with_delays)},
          {"relay", hops_json(hops.relay, with_delays)},
          {"loop", record.foreign_stamps ? OrderedJson::array() : loop_json(record)},
          {"tapes", with_delays ? tapes_json(hops.wires) : OrderedJson::array()}};
}

}  // namespace cas::hils
