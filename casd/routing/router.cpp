// SPDX-License-Identifier: BSD-3-Clause
#include "casd/routing/router.hpp"

#include <utility>

#include "mavlink/common/setup_signing.hpp"

namespace cas::casd {

std::string_view to_string(Route::Decision decision) {
  if (decision == Route::Decision::kCasdOnly) return kCasdOnlyWord;
  return decision == Route::Decision::kForward ? "forwarded" : to_string(cause_of(decision));
}

Router::Router(std::shared_ptr<const RoutingPlan> plan, const mav::MessageTable& table)
    : table_(table),
      routes_{RouteTable(kRouteLifetime), RouteTable(kRouteLifetime), RouteTable(kRouteLifetime),
              RouteTable(kRouteLifetime)},
      plan_(std::move(plan)) {}

/// Word by word, as many as the plan's links fill: 63 links cost one.
inline Route::Decision Router::choose_links(Route& route, const RoutingPlan& plan,
                                            const Routes& routes, const mav::PacketView& packet) {
  const ForwardTable& rules = plan.rules.from(route.info.from);
  const LinkMask& never = plan.never_back[route.info.from];
  const std::size_t words = plan.rules.words();
  SlotMask allowed_anywhere = 0;
  for (std::size_t word = 0; word < words; ++word) {
    const SlotMask allowed =
        rules.destinations(word, packet.message_id, packet.source) & ~never.word(word);
    const SlotMask heard = allowed & routes[word].links_to(route.info.target);
    route.to.set_word(word, heard);
    allowed_anywhere |= allowed;
  }
  if (allowed_anywhere == 0) return Route::Decision::kNoRule;
  if (route.to.empty()) return Route::Decision::kNoTarget;
  const bool has_target = route.info.target.system != 0;  // casd's own station, if it alone has it
  if (route.to == bit(kLocalLink) && !has_target) return Route::Decision::kCasdOnly;
  return Route::Decision::kForward;
}

/// Whether a redundant path has brought this packet already: the second copy ends here. casd's own
/// station still gets it, because it takes a vehicle to be at one link, which may not be the one
/// that brought the first copy.
inline bool Router::came_again(Route& route, const RoutingPlan& plan, const mav::PacketView& packet,
                               base::RunTime now) {
  const LinkId from = route.info.from;
  const bool in_group = is_group_duplicate(from, plan, packet, now);
  const bool anywhere = plan.duplicate_window > base::Duration::zero() &&
                        duplicates_.came_before(from, packet, now, plan.duplicate_window);
  if (anywhere && !in_group) {
    choose_links(route, plan, routes_, packet);
    route.to &= bit(kLocalLink);
  }
  return anywhere || in_group;
}

/// Keeps the packet from links at whose rate limits its turn has not come.
inline void Router::thin_out(Route& route, const RoutingPlan& plan, const mav::PacketView& packet,
                             base::RunTime now) {
  const std::span<const RateLimit> limits = plan.rules.from(route.info.from).limits();
  if (limits.empty()) return;
  const LinkMask wanted = route.to;
  route.to =
      links_[route.info.from].limiter.admit(limits, packet.message_id, packet.source, wanted, now);
  route.thinned = wanted - route.to;
  if (route.to.empty()) route.decision = Route::Decision::kRateLimited;
}

inline Route Router::decide(LinkId from, const RoutingPlan& plan, const mav::PacketView& packet,
                            base::RunTime now, PeerId from_peer) {
  using enum Route::Decision;
  Route route{.info = inspect(packet, table_)};
  route.info.from = from;
  route.info.from_group = plan.group[from];
  route.info.from_peer = from_peer.slot;
  route.info.from_serial = from_peer.serial;
  route.info.received = now;

  // A packet that somebody sends back does not show where its sender is, so no route is learnt.
  const LoopGuard::Verdict loop = loops_.on_packet(from, packet, now);
  if (loop != LoopGuard::Verdict::kFine) [[unlikely]] {
    route.decision = kDuplicate;
    route.loop_found = loop == LoopGuard::Verdict::kFound;
    return route;
  }

  // A sender can be reached over the link that it was heard on.
  routes_[LinkMask::word_of(from)].learn(LinkMask::slot_of(from), packet.source, now,
                                         comes_rarely(packet.message_id));

  // Redundant paths.
  if (came_again(route, plan, packet, now)) {
    route.decision = kDuplicate;
    return route;
  }

  // Sniffers get everything but SETUP_SIGNING, which has a key for its target alone.
  const bool secret = packet.message_id == mavlink::common::SetupSigning::kId;
  if (!secret && !plan.sniffers.empty()) route.sniffers = &plan.sniffers;

  // The rules of the topology, never back, and addressed packets only where the target was heard.
  route.decision = choose_links(route, plan, routes_, packet);
  if (route.decision == kForward) thin_out(route, plan, packet, now);
  return route;
}

/// Learns from HEARTBEATs, and keeps what may spin or move a vehicle from vehicles not in HIL.
void Router::hold_back(Route& route, const RoutingPlan& plan, const mav::PacketView& packet,
                       base::RunTime now) {
  const LinkId from = route.info.from;
  hil_words_.on_packet({.link = from, .peer = route.info.from_serial}, packet, now);
  if (!plan.stops_only.has(from)) return;
  if (route.sniffers != nullptr && HilWords::may_move(packet)) route.sniffers = nullptr;
  const bool recorded = plan.recordings.has(from);
  LinkMask others = route.to;
  others.remove(kLocalLink);
  others.for_each([&](LinkId to) {
    if (hil_words_.permits(to, packet, route.info.target, recorded, now)) return;
    route.to.remove(to);
    ++route.held;
  });
  if (route.held > 0 && route.held == others.count()) route.decision = Route::Decision::kNotHil;
}

Route Router::on_packet(LinkId from, const mav::PacketView& packet, base::RunTime now,
                        PeerId from_peer) {
  const RoutingPlan& plan = plan_for(from);
  Route route = decide(from, plan, packet, now, from_peer);
  if (plan.holds_back) [[unlikely]]
    hold_back(route, plan, packet, now);
  return route;
}

Route Router::on_addressed(const mav::PacketView& packet, std::span<const Path> to,
                           base::RunTime now) {
  Route route = on_packet(kLocalLink, packet, now);
  const LinkMask wanted = with_groups(to);
  route.thinned &= wanted;
  route.to &= wanted;
  if (route.to.empty() && route.decision == Route::Decision::kForward) {
    route.decision = Route::Decision::kNoTarget;
  }
  return route;
}

/// The links of these paths. A link of a group stands for all of them: the station hears only the
/// first copy of a packet, so it cannot know which of them lead to the vehicle.
LinkMask Router::with_groups(std::span<const Path> to) {
  const RoutingPlan& plan = plan_for(kLocalLink);
  LinkMask links;
  for (const Path& path : to) {
    links.add(path.link);
    if (plan.group[path.link] < 0) continue;
    for (std::size_t other = 0; other < plan.group.size(); ++other) {
      if (plan.group[other] == plan.group[path.link]) links.add(static_cast<LinkId>(other));
    }
  }
  return links;
}

void Router::tick(LinkId link, base::RunTime now) {
  routes_[LinkMask::word_of(link)].expire(LinkMask::slot_of(link), now);
}

void Router::forget(LinkId link) {
  routes_[LinkMask::word_of(link)].forget(LinkMask::slot_of(link));
  hil_words_.forget(link);
}

void Router::replace(std::shared_ptr<const RoutingPlan> plan) {
  const base::MutexLock lock(plan_mutex_);
  plan_ = std::move(plan);
  generation_.fetch_add(1, std::memory_order_release);
}

bool Router::passes_unknown(LinkId from) { return plan_for(from).pass_unknown.has(from); }

void Router::renew_plan(LinkId link) {
  PerLink& own = links_[link];
  const base::MutexLock lock(plan_mutex_);
  own.plan = plan_;
  own.generation = generation_.load(std::memory_order_relaxed);
  own.limiter = RateLimiter(own.plan->rules.from(link).limits().size());
}

bool Router::is_group_duplicate(LinkId from, const RoutingPlan& plan, const mav::PacketView& packet,
                                base::RunTime now) {
  const std::int16_t group = plan.group[from];
  return group >= 0 && group_duplicates_[static_cast<std::size_t>(group)].is_duplicate(
                           from, packet, now, kDuplicateWindow);
}

}  // namespace cas::casd
