// SPDX-License-Identifier: BSD-3-Clause
#include "casd/topology/line_budget.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cmath>

#include "casd/queue/line_timing.hpp"
#include "mavlink_gen/runtime/public_table.hpp"

namespace cas::casd {
namespace {

constexpr std::uint32_t kHeartbeat = 0;
constexpr std::uint32_t kHilSensor = 107;

struct ExpectedRate {
  std::uint32_t message_id;
  double hz;
  bool from_simulator;
};

// What a HIL run sends over the controller's line; each vehicle counts once.
constexpr std::array kExpected{
    ExpectedRate{kHeartbeat, 1, true},    // HEARTBEAT
    ExpectedRate{kHilSensor, 500, true},  // HIL_SENSOR
    ExpectedRate{113, 5, true},           // HIL_GPS
    ExpectedRate{91, 400, false},         // HIL_CONTROLS
};
constexpr std::array<unsigned, 8> kUsualBauds{57'600,  115'200, 230'400,   460'800,
                                              500'000, 921'600, 1'500'000, 3'000'000};

bool contains(const std::vector<std::uint32_t>& ids, std::uint32_t id) {
  return std::find(ids.begin(), ids.end(), id) != ids.end();
}

bool blocks(const ForwardRule& rule, std::uint32_t id) { return contains(rule.block, id); }

bool names(const ForwardRule& rule, std::uint32_t id) {
  return rule.allow && contains(*rule.allow, id) && !blocks(rule, id);
}

bool may_come_from(const Topology& topology, const RouteConfig& route, std::uint32_t id) {
  return find_link(topology.links, route.from)->accept.may_accept(id);
}

/// A controller that flies on no simulated sensors sends no HIL_CONTROLS.
bool gets_sensors(const Topology& topology, const std::string& link) {
  return std::ranges::any_of(topology.routes, [&](const RouteConfig& route) {
    if (route.to != link || !may_come_from(topology, route, kHilSensor)) return false;
    if (names(route.rule, kHilSensor)) return true;
    const bool from_line = find_link(topology.links, route.from)->type == LinkType::kSerial;
    return !from_line && !route.rule.allow && !blocks(route.rule, kHilSensor);
  });
}

// A route without an allow list says nothing of the streams behind it: simulators come over
// sockets, controllers over lines.
bool may_carry(const Topology& topology, const RouteConfig& route, const ExpectedRate& expected) {
  if (route.rule.allow || blocks(route.rule, expected.message_id)) return false;
  const bool from_line = find_link(topology.links, route.from)->type == LinkType::kSerial;
  if (expected.from_simulator || !from_line) return expected.from_simulator != from_line;
  return gets_sensors(topology, route.from);
}

double limited_hz(const ForwardRule& rule, std::uint32_t id, double hz) {
  for (const RateRule& rate : rule.rates) {
    if (rate.message_id != id) continue;
    hz /= rate.every;
    if (rate.max_hz > 0) hz = std::min(hz, rate.max_hz);
  }
  return hz;
}

double packet_bytes(std::uint32_t id) {
  const mav::MessageInfo* known = mav::public_table().find(id);
  const std::size_t payload = known == nullptr ? 0 : known->max_length;
  return static_cast<double>(mav::kHeaderBytesV2 + payload + mav::kChecksumBytes);
}

double capacity(const LinkConfig& link) {
  const double line = LinePacer::rate_of(lowest_baud(link));
  if (line > 0 && link.max_bytes_s > 0) return std::min(line, link.max_bytes_s);
  return std::max(line, link.max_bytes_s);
}

// The rate of one message to one link: the highest that a route lets through.
double rate_to(const Topology& topology, const std::string& link, const ExpectedRate& expected,
               bool named) {
  double hz = 0;
  for (const RouteConfig& route : topology.routes) {
    if (route.to != link) continue;
    if (!may_come_from(topology, route, expected.message_id)) continue;
    const bool carries =
        named ? names(route.rule, expected.message_id) : may_carry(topology, route, expected);
    if (carries) hz = std::max(hz, limited_hz(route.rule, expected.message_id, expected.hz));
  }
  return hz;
}

bool any_route_names(const Topology& topology, const std::string& link) {
  return std::any_of(topology.routes.begin(), topology.routes.end(), [&](const RouteConfig& route) {
    return route.to == link &&
           std::any_of(kExpected.begin(), kExpected.end(), [&](const ExpectedRate& expected) {
             return expected.message_id != kHeartbeat && names(route.rule, expected.message_id) &&
                    may_come_from(topology, route, expected.message_id);
           });
  });
}

std::string name_of(std::uint32_t id) {
  const mav::MessageInfo* known = mav::public_table().find(id);
  return known == nullptr ? std::to_string(id) : std::string(known->name);
}

// ", HIL_SENSOR fits up to 128 Hz; 460800 baud carry it"
std::string remedy(const LineBudget& budget) {
  std::string words;
  if (const double hz = budget.fitting_sensor_hz(); hz >= 1) {
    words += fmt::format(", HIL_SENSOR fits up to {:.0f} Hz", std::floor(hz));
  }
  if (const unsigned baud = budget.fitting_baud(); baud > 0 && !budget.fits()) {
    words += fmt::format(", {} baud would carry it", baud);
  }
  return words;
}

std::string warning(const LineBudget& budget) {
  return fmt::format(
      "link {} carries {:.1f} kB/s, its routes may send {:.1f} kB/s at the assumed rates{}",
      budget.link, budget.capacity_bytes_s / 1e3, budget.load_bytes_s() / 1e3, remedy(budget));
}

}  // namespace

double LineBudget::load_bytes_s() const {
  double sum = 0;
  for (const LineLoad& load : loads) sum += load.bytes_s();
  return sum;
}

bool LineBudget::has_streams() const {
  return std::ranges::any_of(loads,
                             [](const LineLoad& load) { return load.message_id != kHeartbeat; });
}

double LineBudget::fitting_sensor_hz() const {
  for (const LineLoad& load : loads) {
    if (load.message_id != kHilSensor) continue;
    return std::max(0.0, capacity_bytes_s - (load_bytes_s() - load.bytes_s())) / load.packet_bytes;
  }
  return 0;
}

unsigned LineBudget::fitting_baud() const {
  for (const unsigned usual : kUsualBauds) {
    if (LinePacer::rate_of(usual) >= load_bytes_s()) return usual;
  }
  return 0;
}

std::vector<LineBudget> line_budgets(const Topology& topology) {
  std::vector<LineBudget> budgets;
  for (const LinkConfig& link : topology.links) {
    LineBudget budget{.link = link.name,
                      .baud = lowest_baud(link),
                      .capacity_bytes_s = capacity(link),
                      .loads = {}};
    if (budget.capacity_bytes_s <= 0) continue;
    const bool named = any_route_names(topology, link.name);
    for (const ExpectedRate& expected : kExpected) {
      const double hz = rate_to(topology, link.name, expected, named);
      if (hz > 0)
        budget.loads.push_back({expected.message_id, hz, packet_bytes(expected.message_id)});
    }
    budgets.push_back(std::move(budget));
  }
  return budgets;
}

std::vector<std::string> line_budget_warnings(const Topology& topology) {
  std::vector<std::string> sentences;
  for (const LineBudget& budget : line_budgets(topology)) {
    if (!budget.fits()) sentences.push_back(warning(budget));
  }
  return sentences;
}

std::string describe(const std::vector<LineBudget>& budgets) {
  std::string text;
  for (const LineBudget& budget : budgets) {
    const std::string rate = budget.baud > 0 ? fmt::format(" at {} baud", budget.baud) : "";
    text += fmt::format("  {}: carries {:.1f} kB/s{}\n", budget.link, budget.capacity_bytes_s / 1e3,
                        rate);
    for (const LineLoad& load : budget.loads) {
      text +=
          fmt::format("    {:24} {:6.0f} Hz assumed x {:3.0f} bytes = {:6.1f} kB/s\n",
                      name_of(load.message_id), load.hz, load.packet_bytes, load.bytes_s() / 1e3);
    }
    if (!budget.has_streams()) {
      text += "    no stream of a HIL run; 'casctl budget' measures what goes over it\n";
      continue;
    }
    text += fmt::format("    {:24} {:38.1f} kB/s, {:.0f} %: {}{}\n", "in all",
                        budget.load_bytes_s() / 1e3,
                        100 * budget.load_bytes_s() / budget.capacity_bytes_s,
                        budget.fits() ? "fits" : "TOO MUCH", remedy(budget));
  }
  return text;
}

}  // namespace cas::casd
