// SPDX-License-Identifier: BSD-3-Clause
#include "casd/routing/router.hpp"

#include <utility>

namespace cas::casd {

std::string_view to_string(Route::Decision decision) {
  switch (decision) {
    case Route::Decision::kForward:
      return "forwarded";
    case Route::Decision::kDuplicate:
      return "duplicate";
    case Route::Decision::kNoRule:
      return "no_rule";
    case Route::Decision::kNoTarget:
      return "no_target";
    case Route::Decision::kRateLimited:
      return "rate_limited";
  }
  return "?";
}

Router::Router(std::shared_ptr<const RoutingPlan> plan, const mav::MessageTable& table,
               base::Duration route_lifetime)
    : table_(table), routes_(route_lifetime), plan_(std::move(plan)) {
  for (auto& filter : duplicates_) filter = std::make_unique<DuplicateFilter>(kDuplicateWindow);
}

Route Router::on_packet(LinkId from, const mav::PacketView& packet, base::RunTime now,
                        PeerId from_peer) {
  using enum Route::Decision;
  const RoutingPlan& plan = plan_for(from);
  Route route{.info = inspect(packet, table_)};
  route.info.from = from;
  route.info.from_group = plan.group[from];
  route.info.from_peer = from_peer.slot;
  route.info.from_serial = from_peer.serial;
  route.info.received = now;

  // A sender can be reached over the link that it was heard on.
  routes_.learn(from, packet.source, now);

  // Redundant paths: the second copy ends here.
  if (is_duplicate(from, plan, packet, now)) {
    route.decision = kDuplicate;
    return route;
  }

  // The rules of the topology, and never back.
  const ForwardTable& rules = plan.rules.from(from);
  route.to = rules.destinations(packet.message_id, packet.source) & ~plan.never_back[from];
  if (route.to == 0) {
    route.decision = kNoRule;
    return route;
  }

  // Addressed packets go only where the target was heard.
  route.to &= routes_.links_to(route.info.target);
  if (route.to == 0) {
    route.decision = kNoTarget;
    return route;
  }

  // Thinned-out streams.
  if (!rules.limits().empty()) {
    const LinkMask wanted = route.to;
    route.to =
        links_[from].limiter.admit(rules.limits(), packet.message_id, packet.source, wanted, now);
    route.thinned = wanted & ~route.to;
    if (route.to == 0) route.decision = kRateLimited;
  }
  return route;
}

Route Router::on_addressed(const mav::PacketView& packet, std::span<const Path> to,
                           base::RunTime now) {
  Route route = on_packet(kLocalLink, packet, now);
  const LinkMask wanted = with_groups(to);
  route.thinned &= wanted;
  route.to &= wanted;
  if (route.to == 0 && route.decision == Route::Decision::kForward) {
    route.decision = Route::Decision::kNoTarget;
  }
  return route;
}

/// The links of these paths. A link of a group stands for all of them: the station hears only the
/// first copy of a packet, so it cannot know which of them lead to the vehicle.
LinkMask Router::with_groups(std::span<const Path> to) {
  const RoutingPlan& plan = plan_for(kLocalLink);
  LinkMask links = 0;
  for (const Path& path : to) {
    links |= bit(path.link);
    for (std::size_t other = 0; other < plan.group.size(); ++other) {
      const bool same = plan.group[path.link] >= 0 && plan.group[other] == plan.group[path.link];
      if (same) links |= bit(static_cast<LinkId>(other));
    }
  }
  return links;
}

void Router::tick(LinkId link, base::RunTime now) { routes_.expire(link, now); }

void Router::forget(LinkId link) { routes_.forget(link); }

void Router::replace(std::shared_ptr<const RoutingPlan> plan) {
  const base::MutexLock lock(plan_mutex_);
  plan_ = std::move(plan);
  generation_.fetch_add(1, std::memory_order_release);
}

bool Router::passes_unknown(LinkId from) { return (plan_for(from).pass_unknown & bit(from)) != 0; }

const RoutingPlan& Router::plan_for(LinkId link) {
  PerLink& own = links_[link];
  if (own.generation != generation_.load(std::memory_order_acquire)) {
    const base::MutexLock lock(plan_mutex_);
    own.plan = plan_;
    own.generation = generation_.load(std::memory_order_relaxed);
    own.limiter = RateLimiter(own.plan->rules.from(link).limits().size());
  }
  return *own.plan;
}

bool Router::is_duplicate(LinkId from, const RoutingPlan& plan, const mav::PacketView& packet,
                          base::RunTime now) {
  const std::int8_t group = plan.group[from];
  return group >= 0 &&
         duplicates_[static_cast<std::uint8_t>(group)]->is_duplicate(from, packet, now);
}

}  // namespace cas::casd
