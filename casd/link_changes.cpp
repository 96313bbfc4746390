// SPDX-License-Identifier: BSD-3-Clause
#include "casd/link_changes.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <exception>
#include <memory>
#include <utility>
#include <vector>

#include "base/config/config.hpp"
#include "base/error.hpp"
#include "base/os/log.hpp"
#include "casd/topology/link_change.hpp"
#include "mavlink/common/hil_sensor.hpp"

namespace cas::casd {

void LinkChanges::apply(Topology topology) {
  const LinkMask gone = links_.reload(std::move(topology));
  // A new link may get the number of one that is gone: packets of the old one are heard first.
  failures_.begin_reload(gone, base::steady_now());
  scheduler_.hear();
  failures_.end_reload();
  commander_.forget(gone);
}

std::string LinkChanges::add(const base::ConfigNode& request) {
  std::vector<std::uint8_t> vehicles;
  for (const VehicleState* vehicle : commander_.vehicles()) {
    vehicles.push_back(vehicle->source().system);
  }
  Topology topology = with_link(links_.topology(), request, vehicles);
  const std::string name = topology.links.back().name;
  apply_at_run_time(std::move(topology));
  added_.insert(name);
  base::log::info("link " + name + ": added at run time");
  return name;
}

void LinkChanges::remove(const std::string& name, bool force) {
  Topology topology = without_link(links_.topology(), name);
  if (const auto need = need_in_flight(name); need && !force) {
    throw base::ConfigError(*need + "; \"force\" removes it all the same");
  }
  apply_at_run_time(std::move(topology));
  added_.erase(name);
  base::log::info("link " + name + ": removed at run time");
}

void LinkChanges::forget_added() {
  for (const std::string& name : std::exchange(added_, {})) {
    if (find_link(links_.topology().links, name) != nullptr) continue;
    base::log::info("link " + name + ": not in the topology, ended");
  }
}

void LinkChanges::when_tried(const std::string& link, base::RunTime until,
                             std::function<void(const std::string&)> then) {
  constexpr auto kPoll = std::chrono::milliseconds(5);
  const auto is_opening = [&link](const LinkStatus& status) {
    return status.name == link && status.state == LinkState::kOpening;
  };
  const bool waits = std::ranges::any_of(links_.figures().links(), is_opening);
  if (!waits || base::steady_now() >= until) return then(link);
  const auto timer = std::make_shared<boost::asio::steady_timer>(io_, kPoll);
  timer->async_wait(
      [this, timer, link, until, then = std::move(then)](boost::system::error_code error) {
        if (!error) when_tried(link, until, then);
      });
}

/// Turns every exception, also for lack of descriptors or threads, into a ConfigError.
void LinkChanges::apply_at_run_time(Topology topology) {
  try {
    apply(std::move(topology));
  } catch (const std::exception& error) {
    throw base::ConfigError(error.what());
  }
}

/// Why an armed vehicle needs the link: casd hears it on no other, or its HIL_SENSOR comes there.
std::optional<std::string> LinkChanges::need_in_flight(const std::string& link) const {
  const base::RunTime now = scheduler_.now();
  const auto name_of = [this](LinkId id) { return links_.figures().name(id); };
  for (const VehicleState* vehicle : commander_.vehicles()) {
    if (!vehicle->armed()) continue;
    const std::string who = fmt::format("vehicle {} is armed and ", vehicle->source().system);
    const auto hangs_here = [&](const Path& path) {
      return name_of(path.link) == link && vehicle->hangs_on(path.link, now);
    };
    if (std::ranges::any_of(vehicle->paths(), hangs_here)) {
      return who + "on link '" + link + "' alone";
    }
    const auto simulator =
        links_.figures().sender_of(mavlink::common::HilSensor::kId, vehicle->link());
    if (simulator && name_of(simulator->second) == link) {
      return who + "flies on HIL_SENSOR of link '" + link + "'";
    }
  }
  return std::nullopt;
}

}  // namespace cas::casd
