// SPDX-License-Identifier: BSD-3-Clause
#include "casd/link_set.hpp"

#include <algorithm>
#include <utility>
#include <vector>

#include "base/error.hpp"
#include "base/text.hpp"
#include "casd/topology/routing_plan.hpp"
#include "casd/transport/serial_link.hpp"
#include "casd/transport/tcp_link.hpp"
#include "casd/transport/tlog_link.hpp"
#include "casd/transport/udp_link.hpp"
#include "casd/transport/udp_server_link.hpp"

namespace cas::casd {
namespace {

/// Makes the link that a configuration asks for. It opens itself once its loop runs.
std::unique_ptr<Link> make_link(LinkContext context) {
  switch (context.config.type) {
    case LinkType::kUdp:
      if (context.config.remote.empty()) return std::make_unique<UdpServerLink>(std::move(context));
      return std::make_unique<UdpLink>(std::move(context));
    case LinkType::kUdpServer:
      return std::make_unique<UdpServerLink>(std::move(context));
    case LinkType::kSerial:
      return std::make_unique<SerialLink>(std::move(context));
    case LinkType::kTcp:
      return std::make_unique<TcpLink>(std::move(context));
    case LinkType::kTcpServer:
      return std::make_unique<TcpServerLink>(std::move(context));
    case LinkType::kTlog:
      return std::make_unique<TlogLink>(std::move(context));
  }
  CAS_CHECK(false);
  return nullptr;
}

}  // namespace

LinkSet::LinkSet(Topology topology, RetryTimes retry)
    : retry_(retry),
      topology_(std::move(topology)),
      switchboard_(make_plan(topology_, slots_in_order(topology_))),
      local_(std::make_shared<LocalEndpoint>(switchboard_, topology_.self)) {
  commit(prepare(topology_, {}));
}

LinkSet::~LinkSet() {
  stop();
  local_->let_go();
}

void LinkSet::start() {
  started_ = true;
  if (common_loop_) common_loop_->start();
  for (const auto& [name, running] : running_) running.home->start();
}

void LinkSet::stop() {
  for (const auto& [name, running] : running_) running.home->stay();
  if (common_loop_) common_loop_->stop();
  for (const auto& [name, running] : running_) running.home->stop();
}

LinkMask LinkSet::reload(Topology topology) {
  const std::vector<std::string> restart = restart_keys(topology_, topology);
  if (!restart.empty()) throw base::ConfigError(restart.front() + ": takes a restart");
  // All steps that may fail come first and change nothing; the rest only swaps.
  const std::set<std::string> kept = unchanged(topology);
  Change change = prepare(topology, kept);
  std::vector<std::string> gone;
  for (const auto& [name, running] : running_) {
    if (!kept.contains(name)) gone.push_back(name);
  }
  LinkMask closed;
  for (const std::string& name : gone) {
    closed.add(running_.at(name).id);
    close(name);
  }
  topology_ = std::move(topology);
  commit(std::move(change));
  return closed;
}

bool LinkSet::settled() const {
  const auto links = figures_.links();
  return std::none_of(links.begin(), links.end(),
                      [](const LinkStatus& link) { return link.state == LinkState::kOpening; });
}

bool LinkSet::alive(base::RunTime now) {
  constexpr auto kPatience = std::chrono::seconds(5);
  bool all = true;
  for (const auto& [name, running] : running_) {
    if (!running.home->answers(now, kPatience)) all = false;
  }
  return all;
}

std::string LinkSet::endpoints() const {
  return base::joined(figures_.links(), " ", [](const LinkStatus& link) {
    return link.name + " " +
           (link.state == LinkState::kUp ? link.endpoint : std::string(to_string(link.state)));
  });
}

std::set<std::string> LinkSet::unchanged(const Topology& topology) const {
  std::set<std::string> names;
  for (const LinkConfig& config : topology.links) {
    const auto running = running_.find(config.name);
    if (running != running_.end() && running->second.config == config) names.insert(config.name);
  }
  return names;
}

LinkSet::Change LinkSet::prepare(const Topology& topology, const std::set<std::string>& kept) {
  Change change;
  change.keys = keys_;
  change.keys.read(topology.links);
  LinkSlots slots;
  auto ports = std::make_shared<PortTable>();
  LinkMask taken = bit(kLocalLink);
  for (const std::string& name : kept) {
    const Running& running = running_.at(name);
    slots.emplace(name, running.id);
    (*ports)[running.id] = running.port;
    taken.add(running.id);
  }
  for (const LinkConfig& config : topology.links) {
    if (kept.contains(config.name)) continue;
    const LinkId id = taken.first_missing();
    const Opening& opening =
        change.openings.emplace_back(make_opening(topology, config, id, change.keys));
    slots.emplace(config.name, id);
    (*ports)[id] = opening.running.port;
    taken.add(id);
  }
  (*ports)[kLocalLink] = local_;
  change.plan = make_plan(topology, slots);
  change.ports = std::move(ports);
  return change;
}

LinkSet::Opening LinkSet::make_opening(const Topology& topology, const LinkConfig& config,
                                       LinkId id, const SigningKeys& keys) {
  Opening opening;
  opening.running = {.config = config, .id = id, .port = {}, .home = home_for(topology, config)};
  opening.counters = figures_.make_link(config.name, config.type);
  opening.link = make_link({.id = id,
                            .config = config,
                            .switchboard = switchboard_,
                            .counters = opening.counters,
                            .signing = keys.for_link(config, opening.counters),
                            .wake = [home = opening.running.home] { home->wake(); },
                            .blocking = topology.threads == ThreadModel::kBlocking,
                            .drain = LineDrain(topology.drain_tick),
                            .retry = retry_});
  opening.running.link = opening.link.get();
  opening.running.port = opening.link->port();
  if (started_) opening.running.home->start();
  return opening;
}

void LinkSet::commit(Change change) {
  // Rules first: the port of a link that has not begun takes nothing, but a link under the old
  // rules could send to a port that the new ones forbid.
  switchboard_.router().replace(std::move(change.plan));
  switchboard_.set_ports(std::move(change.ports));
  keys_ = std::move(change.keys);
  keys_.begin();
  for (Opening& opening : change.openings) {
    Running& running = opening.running;
    figures_.add_link(running.id, std::move(opening.counters));
    running.home->add(std::move(opening.link));
    const std::string name = running.config.name;
    running_.emplace(name, std::move(running));
  }
}

void LinkSet::close(const std::string& name) {
  const auto found = running_.find(name);
  Running& running = found->second;
  running.home->remove(running.link);
  // The link's thread has let go of the slot.
  switchboard_.router().forget(running.id);
  figures_.remove_link(running.id);
  running_.erase(found);
}

std::shared_ptr<LinkHome> LinkSet::home_for(const Topology& topology, const LinkConfig& config) {
  const bool seek_core = topology.seek_core && topology.pace == Pace::kRealtime;
  const bool scheduled = config.scheduling.fifo_priority || !config.scheduling.cpus.empty();
  const auto make_own = [seek_core, name = config.name,
                         scheduling = scheduled ? config.scheduling : topology.scheduling] {
    return std::make_unique<LinkLoop>(name, scheduling, seek_core);
  };
  const bool automatic = topology.threads == ThreadModel::kAuto;
  if (topology.threads == ThreadModel::kPerLink || (automatic && scheduled)) {
    return std::make_shared<LinkHome>(make_own());
  }
  if (!common_loop_) {
    auto loop = std::make_shared<LinkLoop>("links", topology.scheduling, seek_core);
    if (started_) loop->start();
    common_loop_ = std::move(loop);
  }
  return automatic ? std::make_shared<LinkHome>(common_loop_, make_own)
                   : std::make_shared<LinkHome>(common_loop_);
}

}  // namespace cas::casd
