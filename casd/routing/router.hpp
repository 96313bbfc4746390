// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <span>
#include <string_view>

#include "base/os/mutex.hpp"
#include "base/time/clock.hpp"
#include "casd/packet/link_mask.hpp"
#include "casd/packet/packet_info.hpp"
#include "casd/routing/duplicate_filter.hpp"
#include "casd/routing/hil_words.hpp"
#include "casd/routing/loop_guard.hpp"
#include "casd/routing/route_table.hpp"
#include "casd/routing/routing_rules.hpp"
#include "casd/words/drop_cause.hpp"
#include "mavlink_gen/runtime/message_table.hpp"

namespace cas::casd {

/// All rules of the router: immutable, replaced together.
struct RoutingPlan {
  ForwardRules rules;
  /// For each link, the links that never get its packets: its group. Without a group that is the
  /// link itself; a server link whose peers may talk to each other excludes none.
  std::array<LinkMask, kLinkSlots> never_back{};
  /// Group number per link, -1: none. Packets that come twice into a group go on once.
  std::array<std::int16_t, kLinkSlots> group;
  /// Packets that come again within this time, over whichever link, go on once; zero: only groups.
  base::Duration duplicate_window{};
  LinkMask pass_unknown;  ///< links from which packets with unknown message ids go on
  LinkMask sniffers;      ///< links that get every packet; no rule names them
  /// Links whose packets may stop a vehicle that is not in HIL, and neither spin nor move it.
  LinkMask stops_only;
  LinkMask recordings;      ///< links that play a log
  bool holds_back = false;  ///< whether `stops_only` has any

  RoutingPlan() { group.fill(-1); }
};

/// Where a packet goes, and why it may go nowhere.
struct Route {
  enum class Decision : std::uint8_t {
    kForward,      ///< `to` may still be empty: no link wants it
    kDuplicate,    ///< came already; `to` is casd's own station, unless it heard the packet, or
                   ///< the packet goes round in a loop
    kNoRule,       ///< the rules let it go nowhere
    kNoTarget,     ///< addressed to a system that was never heard
    kRateLimited,  ///< its turn has not come
    kNotHil,       ///< may spin or move a vehicle that is not in HIL; `to` is casd's own station
    kCasdOnly      ///< for all, but only casd's own station may have it
  };
  LinkMask to{};
  LinkMask thinned{};     ///< links that a rate limit keeps it from
  std::uint8_t held = 0;  ///< how many links it is kept from for a vehicle there that is not in HIL
  Decision decision = Decision::kForward;
  bool loop_found = false;  ///< the first packet that proves a loop
  /// Links that get it beside `to`, whatever was decided; of the plan, until the next packet.
  const LinkMask* sniffers = nullptr;
  PacketInfo info;
};
inline constexpr int kDecisions = 7;
inline constexpr int kRouterRefusals = kDecisions - 2;
/// Whether it counts as dropped, with a DropCause.
constexpr bool is_refusal(Route::Decision decision) {
  return decision != Route::Decision::kForward && decision != Route::Decision::kCasdOnly;
}
/// The cause under which a refused packet counts as dropped.
constexpr DropCause cause_of(Route::Decision decision) {
  return static_cast<DropCause>(static_cast<int>(DropCause::kDuplicate) +
                                static_cast<int>(decision) - 1);
}
static_assert(cause_of(Route::Decision::kDuplicate) == DropCause::kDuplicate &&
              cause_of(Route::Decision::kNoRule) == DropCause::kNoRule &&
              cause_of(Route::Decision::kNoTarget) == DropCause::kNoTarget &&
              cause_of(Route::Decision::kRateLimited) == DropCause::kRateLimited &&
              cause_of(Route::Decision::kNotHil) == DropCause::kNotHil);
/// "forwarded", "casd_only", or the word of its cause.
std::string_view to_string(Route::Decision decision);

/// Decides by the MAVLink routing guide and the rules of the topology where each packet goes. It
/// moves no bytes and reads no clock. Each link's Ingress asks it about every packet that it
/// admits, and hands the packet to the links of the answer.
///
///   Route route = router.on_packet(link, packet, now);  // route.to: links that get it
///   router.tick(link, now);                             // once a second
///   router.replace(plan);                               // after a reload of the topology
///   router.forget(link);                                // the link is gone
///
/// `on_packet`, `tick` and `forget` for one link belong to one thread at a time; different links
/// may run on different threads. `replace` may come from any thread.
class Router {
 public:
  static constexpr base::Duration kRouteLifetime = std::chrono::seconds(60);
  static constexpr base::Duration kDuplicateWindow = std::chrono::milliseconds(500);
  static constexpr int kMaxGroups = kMaxLinks;

  Router(std::shared_ptr<const RoutingPlan> plan, const mav::MessageTable& table);

  /// @param from_peer  which peer of a server link sent it
  Route on_packet(LinkId from, const mav::PacketView& packet, base::RunTime now,
                  PeerId from_peer = {});
  /// A packet of casd's own station for one vehicle: goes to these links and others of their
  /// groups, as far as the target was heard there.
  Route on_addressed(const mav::PacketView& packet, std::span<const Path> to, base::RunTime now);
  /// Once a second for each link: forgets routes that fell silent.
  void tick(LinkId link, base::RunTime now);
  /// The link is gone: forgets the systems that were heard on it.
  void forget(LinkId link);
  /// Puts new rules in force. Links take them over at their next packet.
  void replace(std::shared_ptr<const RoutingPlan> plan);
  /// Does the link let packets with unknown message ids pass?
  bool passes_unknown(LinkId from);

 private:
  // State of one link's thread.
  struct alignas(64) PerLink {
    std::shared_ptr<const RoutingPlan> plan;
    std::uint64_t generation = 0;
    RateLimiter limiter;
  };
  using Routes = std::array<RouteTable, LinkMask::kWords>;  // by word of a LinkMask

  static Route::Decision choose_links(Route& route, const RoutingPlan& plan, const Routes& routes,
                                      const mav::PacketView& packet);
  const RoutingPlan& plan_for(LinkId link) {
    if (links_[link].generation != generation_.load(std::memory_order_acquire)) renew_plan(link);
    return *links_[link].plan;
  }
  void renew_plan(LinkId link);
  bool came_again(Route& route, const RoutingPlan& plan, const mav::PacketView& packet,
                  base::RunTime now);
  void thin_out(Route& route, const RoutingPlan& plan, const mav::PacketView& packet,
                base::RunTime now);
  Route decide(LinkId from, const RoutingPlan& plan, const mav::PacketView& packet,
               base::RunTime now, PeerId from_peer);
  void hold_back(Route& route, const RoutingPlan& plan, const mav::PacketView& packet,
                 base::RunTime now);
  LinkMask with_groups(std::span<const Path> to);
  bool is_group_duplicate(LinkId from, const RoutingPlan& plan, const mav::PacketView& packet,
                          base::RunTime now);

  mav::MessageTable table_;
  Routes routes_;
  std::array<PerLink, kLinkSlots> links_;
  std::array<DuplicateFilter, kMaxGroups> group_duplicates_;
  DuplicateFilter duplicates_;  ///< of all links
  LoopGuard loops_;
  HilWords hil_words_;  ///< kept while a plan holds packets back

  std::atomic<std::uint64_t> generation_{1};
  base::Mutex plan_mutex_;
  std::shared_ptr<const RoutingPlan> plan_ CAS_GUARDED_BY(plan_mutex_);
};

}  // namespace cas::casd
