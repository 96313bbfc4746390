// SPDX-License-Identifier: BSD-3-Clause
#include <nlohmann/json.hpp>
#include <utility>

#include "casd/port/command_figures.hpp"
#include "casd/port/metrics_text.hpp"

namespace cas::casd {
namespace {

using nlohmann::json;

double microseconds(base::Duration d) { return base::to_seconds(d) * 1e6; }

template <class Figures>
json times_json(const Figures& figures) {
  json times{{"p50", microseconds(figures.p50)},
             {"p99", microseconds(figures.p99)},
             {"max", microseconds(figures.max)}};
  if constexpr (requires { figures.count; }) times["count"] = figures.count;
  return times;
}

}  // namespace

json CommandFigures::latency() const {
  json all = json::array();
  for (const LinkStatus& link : source_.figures->links()) {
    json entry{{"p50", microseconds(link.tx.forwarding_p50)},
               {"p99", microseconds(link.tx.forwarding_p99)},
               {"max", microseconds(link.tx.forwarding_max)}};
    entry["link"] = link.name;
    entry["routes"] = json::array();
    for (const RouteLatency::Figures& route : link.tx.routes) {
      json from = times_json(route);
      from["from"] = link_name(route.from);
      entry["routes"].push_back(std::move(from));
    }
    all.push_back(std::move(entry));
  }
  return all;
}

/// From a HIL_SENSOR in to the controls that echo its stamp.
json CommandFigures::echo() const {
  json all = json::array();
  if (source_.echo == nullptr) return all;
  for (const EchoLatency::Figures& vehicle : source_.echo->figures()) {
    json entry = times_json(vehicle);
    entry["vehicle"] = vehicle.system;
    entry["count"] = vehicle.matched;
    entry["unmatched"] = vehicle.unmatched;
    all.push_back(std::move(entry));
  }
  return all;
}

/// "casd" is its own station.
std::string CommandFigures::link_name(LinkId id) const {
  for (const LinkStatus& link : source_.figures->links()) {
    if (link.id == id) return link.name;
  }
  return "casd";
}

std::string CommandFigures::metrics() const {
  const base::RunTime now = source_.now();
  MetricsSource all{.uptime_s = base::to_seconds(now - source_.started),
                    .clients = server_.clients(),
                    .links = source_.figures->links(),
                    .messages = source_.figures->messages(now)};
  for (MessageStatus& message : all.messages) message.name = message_name(message.id);
  return metrics_text(all);
}

}  // namespace cas::casd
