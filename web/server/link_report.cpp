// SPDX-License-Identifier: BSD-3-Clause
#include "web/server/link_report.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace cas::web {
namespace {

using base::rpc::Json;

constexpr std::size_t kMostMessages = 12;  // of a hop; the most frequent ones
/// Bits that a serial line takes for a byte: start, eight, stop.
constexpr double kBitsPerByte = 10;
/// Direction of a message in message.list that was dropped; the cause follows.
constexpr std::string_view kDrop = "drop.";

double tenth(double value) { return std::round(10 * value) / 10; }
double thousandth(double value) { return std::round(1000 * value) / 1000; }

bool is_sensor(const std::string& name) { return name == "HIL_SENSOR" || name == "HIL_GPS"; }
bool is_control(const std::string& name) {
  return name == "HIL_CONTROLS" || name == "HIL_ACTUATOR_CONTROLS";
}

/// Traffic in one direction of a link, by message, Hz.
struct Way {
  std::vector<std::pair<std::string, double>> rates;
  bool sensors = false;
  bool controls = false;
  int system = 0;  ///< that sends the HIL messages
};

Way way_of(const Json& messages, const std::string& link, const std::string& direction) {
  Way way;
  for (const Json& message : messages) {
    if (message.value("link", "") != link || message.value("direction", "") != direction) continue;
    const std::string name = message.value("name", "");
    way.sensors |= is_sensor(name);
    way.controls |= is_control(name);
    if (is_sensor(name) || is_control(name)) way.system = message.value("system", way.system);
    const auto same = std::find_if(way.rates.begin(), way.rates.end(),
                                   [&](const auto& rate) { return rate.first == name; });
    const double hz = message.value("hz", 0.0);
    if (same != way.rates.end()) {
      same->second += hz;  // of several senders
    } else {
      way.rates.emplace_back(name, hz);
    }
  }
  std::stable_sort(way.rates.begin(), way.rates.end(),
                   [](const auto& a, const auto& b) { return a.second > b.second; });
  return way;
}

Json rates_json(const Way& way) {
  Json rates = Json::object();
  for (const auto& [name, hz] : way.rates) {
    if (rates.size() < kMostMessages) rates[name] = tenth(hz);
  }
  return rates;
}

/// HIL packets that casd dropped on their way to a link, by cause. @param causes  of what is sent
Json dropped_json(const Json& messages, const std::string& link, const Json& causes) {
  Json dropped = Json::object();
  for (const Json& message : messages) {
    const std::string direction = message.value("direction", "");
    if (message.value("link", "") != link || !direction.starts_with(kDrop) ||
        !message.value("name", "").starts_with("HIL_")) {
      continue;
    }
    const std::string cause = direction.substr(kDrop.size());
    if (causes.contains(cause))
      dropped[cause] = dropped.value(cause, std::int64_t{0}) + message.value("count", std::int64_t{0});
  }
  return dropped;
}

Json hop(const Json& link, const std::string& from, const std::string& to, int system,
         const Way& way) {
  Json entry{{"from", from},
             {"to", to},
             {"link", link.value("name", "")},
             {"system", system},
             {"type", link.value("type", "")},
             {"state", link.value("state", "")},
             {"endpoint", link.value("endpoint", "")},
             {"msgs", rates_json(way)},
             {"measured", "none"}};
  if (link.contains("baud")) entry["baud"] = link["baud"];
  return entry;
}

}  // namespace

double LinkReport::share(const std::string& way, double bytes, double baud, base::RunTime now) {
  const auto [last, is_first] = bytes_.try_emplace(way, now, bytes);
  const auto [then, before] = std::exchange(last->second, {now, bytes});
  const double time_s = base::to_seconds(now - then);
  if (is_first || time_s <= 0 || bytes < before) return -1;
  return (bytes - before) * kBitsPerByte / (baud * time_s);
}

void LinkReport::add_link(Json& hops, const Json& link, const Json& messages, base::RunTime now) {
  const std::string name = link.value("name", "");
  const Way rx = way_of(messages, name, "rx");
  const Way tx = way_of(messages, name, "tx");
  // Sensors come from the simulator, controls from a controller; a ground station is no hop.
  if (!(rx.sensors || tx.controls || tx.sensors || rx.controls)) return;
  const bool simulator = rx.sensors || tx.controls;
  const std::string role = simulator ? "sim" : "fcu";
  // Controls come from the vehicle itself; a simulator may send under another number.
  const int system = rx.controls   ? rx.system
                     : tx.controls ? tx.system
                                   : std::max(rx.system, tx.system);
  ends_[name] = {role, system};
  const Json received = link.value("rx", Json::object());
  const Json sent = link.value("tx", Json::object());
  Json in = hop(link, role, "casd", system, rx);
  in["lost"] = received.value("lost", 0);
  Json out = hop(link, "casd", role, system, tx);
  out["queued"] = sent.value("queued", 0);
  out["high_water"] = sent.value("queue_high_water", 0);
  out["dropped"] = dropped_json(messages, name, sent.value("dropped", Json::object()));
  if (const double baud = link.value("baud", 0.0); baud > 0) {
    const double in_share = share(name + " rx", received.value("bytes", 0.0), baud, now);
    const double out_share = share(name + " tx", sent.value("bytes", 0.0), baud, now);
    if (in_share >= 0) in["full"] = thousandth(in_share);
    if (out_share >= 0) out["full"] = thousandth(out_share);
  }
  hops.push_back(simulator ? in : out);
  hops.push_back(simulator ? std::move(out) : std::move(in));
}

/// A link on which no HIL packets go has none but its name.
std::string LinkReport::role_of(const std::string& link) const {
  const auto end = ends_.find(link);
  return end == ends_.end() ? link : end->second.role;
}

Json LinkReport::make(const Json& links, const Json& messages, const Json& latency,
                      base::RunTime now) {
  ends_.clear();
  Json hops = Json::array();
  for (const Json& link : links) add_link(hops, link, messages, now);
  Json forward = Json::array();
  for (const Json& link : latency) {
    for (Json route : link.value("routes", Json::array())) {
      if (route.value("count", 0) == 0) continue;
      const std::string from = route.value("from", "");
      const std::string to = link.value("link", "");
      route["from_link"] = from;
      route["to_link"] = to;
      route["from"] = role_of(from);
      route["to"] = role_of(to);
      if (const auto end = ends_.find(to); end != ends_.end()) route["system"] = end->second.system;
      forward.push_back(std::move(route));
    }
  }
  return {{"hops", std::move(hops)}, {"forward_us", std::move(forward)}};
}

}  // namespace cas::web
