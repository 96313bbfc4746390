// SPDX-License-Identifier: BSD-3-Clause
#include "casd/line_budget.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "casd/line_pacer.hpp"
#include "mavlink_gen/runtime/public_table.hpp"

namespace cas::casd {
namespace {

constexpr std::uint32_t kHilSensor = 107;

struct ExpectedRate {
  std::uint32_t message_id;
  double hz;
};

// What a HIL run sends over the controller's line; each vehicle counts once.
constexpr std::array kExpected{
    ExpectedRate{0, 1},             // HEARTBEAT
    ExpectedRate{kHilSensor, 500},  // HIL_SENSOR
    ExpectedRate{113, 5},           // HIL_GPS
    ExpectedRate{91, 400},          // HIL_CONTROLS
};

// Messages that come from the simulator, and from the controller: a line carries the ones or the
// others, told by what the rule names.
bool passes(const ForwardRule& rule, std::uint32_t id) {
  if (std::find(rule.block.begin(), rule.block.end(), id) != rule.block.end()) return false;
  // A route without an allow list says nothing about the HIL streams behind it.
  return rule.allow && std::find(rule.allow->begin(), rule.allow->end(), id) != rule.allow->end();
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
  const double line = link.type == LinkType::kSerial && link.baud > 0
                          ? LinePacer::kLineShare * link.baud / 10.0
                          : 0;
  if (line > 0 && link.max_bytes_s > 0) return std::min(line, link.max_bytes_s);
  return std::max(line, link.max_bytes_s);
}

std::string warning(const LineBudget& budget) {
  double others = 0;
  double sensor_bytes = 0;
  for (const LineLoad& load : budget.loads) {
    if (load.message_id == kHilSensor) {
      sensor_bytes = load.packet_bytes;
    } else {
      others += load.bytes_s();
    }
  }
  std::array<char, 256> text{};
  std::snprintf(text.data(), text.size(),
                "link %s carries %.1f kB/s, its routes may send %.1f kB/s: needs %.0f baud",
                budget.link.c_str(), budget.capacity_bytes_s / 1e3, budget.load_bytes_s() / 1e3,
                std::ceil(budget.load_bytes_s() * 10 / LinePacer::kLineShare));
  std::string sentence = text.data();
  const double left = budget.capacity_bytes_s - others;
  if (sensor_bytes > 0 && left > 0) {
    sentence += ", or HIL_SENSOR at " + std::to_string(static_cast<int>(left / sensor_bytes)) +
                " Hz at most";
  }
  return sentence;
}

}  // namespace

double LineBudget::load_bytes_s() const {
  double sum = 0;
  for (const LineLoad& load : loads) sum += load.bytes_s();
  return sum;
}

std::vector<LineBudget> line_budgets(const Topology& topology) {
  std::vector<LineBudget> budgets;
  for (const LinkConfig& link : topology.links) {
    LineBudget budget{.link = link.name, .capacity_bytes_s = capacity(link), .loads = {}};
    if (budget.capacity_bytes_s <= 0) continue;
    for (const RouteConfig& route : topology.routes) {
      if (route.to != link.name) continue;
      for (const ExpectedRate& expected : kExpected) {
        if (!passes(route.rule, expected.message_id)) continue;
        budget.loads.push_back({expected.message_id,
                                limited_hz(route.rule, expected.message_id, expected.hz),
                                packet_bytes(expected.message_id)});
      }
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

}  // namespace cas::casd
