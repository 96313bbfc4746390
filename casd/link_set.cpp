// SPDX-License-Identifier: BSD-3-Clause
#include "casd/link_set.hpp"

#include <algorithm>
#include <utility>
#include <vector>

#include "base/error.hpp"
#include "casd/link_factory.hpp"

namespace cas::casd {

LinkSet::LinkSet(Topology topology)
    : topology_(std::move(topology)),
      switchboard_(make_plan(topology_, slots_in_order(topology_)), topology_.route_lifetime),
      local_(std::make_shared<LocalEndpoint>(switchboard_, topology_.self)) {
  keys_.read(topology_);
  for (const LinkConfig& config : topology_.links) open(config);
  publish_ports();
}

LinkSet::~LinkSet() {
  stop();
  local_->let_go();
}

void LinkSet::start() {
  started_ = true;
  if (common_loop_) common_loop_->start();
  for (const auto& [name, running] : running_) {
    if (running.loop != common_loop_) running.loop->start();
  }
}

void LinkSet::stop() {
  if (common_loop_) common_loop_->stop();
  for (const auto& [name, running] : running_) running.loop->stop();
}

void LinkSet::reload(Topology topology) {
  if (topology_.pace == Pace::kLockstep) topology.set_lockstep();  // perhaps by a flag
  if (topology.threads != topology_.threads || topology.drain_tick != topology_.drain_tick ||
      topology.pace != topology_.pace || topology.self != topology_.self) {
    throw base::ConfigError(
        "threads, drain_tick_ms, pace, system_id and component_id only change with a restart");
  }
  keys_.read(topology);
  const auto unchanged = [&](const Running& running) {
    return std::any_of(topology.links.begin(), topology.links.end(),
                       [&](const LinkConfig& config) { return config == running.config; });
  };
  std::vector<std::string> gone;
  for (const auto& [name, running] : running_) {
    if (!unchanged(running)) gone.push_back(name);
  }
  for (const std::string& name : gone) close(name);

  topology_ = std::move(topology);
  for (const LinkConfig& config : topology_.links) {
    if (!running_.contains(config.name)) open(config);
  }
  // Rules first: a port that is not there yet takes nothing, a rule that is too old may give.
  switchboard_.router().replace(make_plan(topology_, slots()));
  publish_ports();
}

bool LinkSet::settled() const {
  const auto links = monitor_.links();
  return std::none_of(links.begin(), links.end(),
                      [](const LinkStatus& link) { return link.state == LinkState::kOpening; });
}

bool LinkSet::alive(base::RunTime now) {
  constexpr auto kPatience = std::chrono::seconds(5);
  bool all = true;
  for (const auto& [name, running] : running_) {
    if (running.loop && !running.loop->answers(now, kPatience)) all = false;
  }
  return all;
}

std::string LinkSet::endpoints() const {
  std::string text;
  for (const LinkStatus& link : monitor_.links()) {
    const std::string where =
        link.state == LinkState::kUp ? link.endpoint : std::string(to_string(link.state));
    text += (text.empty() ? "" : " ") + link.name + " " + where;
  }
  return text;
}

void LinkSet::open(const LinkConfig& config) {
  Running running{.config = config, .id = free_slot(), .port = {}, .loop = loop_for(config)};
  auto monitor = monitor_.add_link(running.id, config.name, config.type);
  auto link = make_link({.id = running.id,
                         .config = config,
                         .switchboard = switchboard_,
                         .monitor = monitor,
                         .signing = keys_.for_link(config, monitor),
                         .wake = [loop = running.loop.get()] { loop->wake(); },
                         .blocking = topology_.threads == ThreadModel::kBlocking,
                         .drain = LineDrain(topology_.drain_tick)});
  running.link = link.get();
  running.port = link->port();
  running.loop->add(std::move(link));
  if (started_ && running.loop != common_loop_) running.loop->start();
  running_.emplace(config.name, std::move(running));
}

void LinkSet::close(const std::string& name) {
  const auto found = running_.find(name);
  Running& running = found->second;
  if (running.loop == common_loop_) {
    running.loop->remove(running.link);
  } else {
    running.loop->stop();
  }
  // Its thread has let go of the slot.
  switchboard_.router().forget(running.id);
  monitor_.remove_link(running.id);
  running_.erase(found);
}

LinkId LinkSet::free_slot() const {
  LinkMask taken = 0;
  for (const auto& [name, running] : running_) taken |= bit(running.id);
  return static_cast<LinkId>(std::countr_one(taken));
}

std::shared_ptr<LinkLoop> LinkSet::loop_for(const LinkConfig& config) {
  if (topology_.threads == ThreadModel::kPerLink) {
    const bool own = config.scheduling.fifo_priority || !config.scheduling.cpus.empty();
    return std::make_shared<LinkLoop>(config.name, own ? config.scheduling : topology_.scheduling);
  }
  if (!common_loop_) common_loop_ = std::make_shared<LinkLoop>("links", topology_.scheduling);
  return common_loop_;
}

LinkSlots LinkSet::slots() const {
  LinkSlots slots;
  for (const auto& [name, running] : running_) slots.emplace(name, running.id);
  return slots;
}

void LinkSet::publish_ports() {
  auto ports = std::make_shared<PortTable>();
  for (const auto& [name, running] : running_) (*ports)[running.id] = running.port;
  (*ports)[kLocalLink] = local_;
  switchboard_.set_ports(std::move(ports));
}

}  // namespace cas::casd
