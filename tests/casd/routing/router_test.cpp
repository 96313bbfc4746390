// SPDX-License-Identifier: BSD-3-Clause
#include "casd/routing/router.hpp"

#include <gtest/gtest.h>

#include <map>
#include <random>
#include <set>

#include "mavlink_gen/runtime/public_table.hpp"
#include "tests/casd/packets.hpp"

namespace cas::casd::test {
namespace {

using enum Route::Decision;
using mavlink::common::Heartbeat;

/// Links 0..n-1, each of which may send to each other one.
std::shared_ptr<RoutingPlan> all_to_all(LinkId links) {
  std::vector<ForwardRule> rules;
  auto plan = std::make_shared<RoutingPlan>();
  for (LinkId from = 0; from < links; ++from) {
    plan->never_back[from] = bit(from);
    for (LinkId to = 0; to < links; ++to) {
      rules.emplace_back().from = from;
      rules.back().to = to;
    }
  }
  plan->rules = ForwardRules(rules);
  return plan;
}

Router make_router(LinkId links) { return Router(all_to_all(links), mav::public_table()); }

TEST(Router, BroadcastGoesToAllButTheSource) {
  Router router = make_router(3);
  const auto heartbeat = packet(Heartbeat{}, {1, 1});
  const Route route = router.on_packet(0, view(heartbeat), at({}));
  EXPECT_EQ(route.decision, kForward);
  EXPECT_EQ(route.to, bit(1) | bit(2));
  EXPECT_EQ(route.info.traffic, TrafficClass::kCommand);
}

TEST(Router, AddressedPacketGoesWhereItsTargetWasHeard) {
  Router router = make_router(3);
  const auto command = packet(command_to(1, 1), {255, 190});
  EXPECT_EQ(router.on_packet(0, view(command), at({})).decision, kNoTarget);
  router.on_packet(2, view(packet(Heartbeat{}, {1, 1})), at({}));
  const Route route = router.on_packet(0, view(command), at({}));
  EXPECT_EQ(route.to, bit(2));
  EXPECT_EQ(route.info.target, (mav::Source{1, 1}));
}

TEST(Router, APacketForOneVehicleGoesToItsLinkAndGroupAlone) {
  auto plan = all_to_all(4);
  std::vector<ForwardRule> rules;
  for (LinkId to = 0; to < 4; ++to) {
    rules.emplace_back().from = kLocalLink;
    rules.back().to = to;
  }
  plan->rules = ForwardRules(rules);
  plan->group[1] = plan->group[2] = 0;
  Router router(plan, mav::public_table());
  const auto command = packet(command_to(1, 1), {254, 190});
  for (LinkId link = 0; link < 4; ++link) {
    router.on_packet(link, view(packet(Heartbeat{}, {1, 1})), at({}));
  }
  EXPECT_EQ(router.on_addressed(view(command), std::vector<Path>{{0}}, at({})).to, bit(0));
  EXPECT_EQ(router.on_addressed(view(command), std::vector<Path>{{1}}, at({})).to, bit(1) | bit(2));
  const auto stranger = packet(command_to(7, 1), {254, 190});
  EXPECT_EQ(router.on_addressed(view(stranger), std::vector<Path>{{0}}, at({})).decision,
            kNoTarget);
}

/// Link 0 may only stop vehicles that are not in HIL.
std::shared_ptr<RoutingPlan> guarded(LinkId links) {
  auto plan = all_to_all(links);
  plan->stops_only = bit(0);
  plan->holds_back = true;
  return plan;
}

Heartbeat heartbeat_of(bool in_hil) {
  using mavlink::common::MavModeFlag;
  Heartbeat message{
      .autopilot = mavlink::common::MavAutopilot::kPx4,
      .base_mode = in_hil ? MavModeFlag::kHilEnabled : MavModeFlag::kCustomModeEnabled};
  return message;
}

mavlink::common::CommandLong arming(std::uint8_t system) {
  auto command = command_to(system, 1);
  command.param1 = 1;
  return command;
}

TEST(RouterInterlock, GoesByTheNewestHeartbeatOfTheTarget) {
  Router router(guarded(3), mav::public_table());
  const auto arm = packet(arming(1), {255, 190});
  router.on_packet(1, view(packet(heartbeat_of(true), {1, 1})), at({}));
  EXPECT_EQ(router.on_packet(0, view(arm), at({})).decision, kForward);
  router.on_packet(1, view(packet(heartbeat_of(false), {1, 1})), at({}));
  const Route held = router.on_packet(0, view(arm), at({}));
  EXPECT_EQ(held.decision, kNotHil);
  EXPECT_EQ(held.held, 1);
  EXPECT_TRUE(held.to.empty());
  router.on_packet(1, view(packet(heartbeat_of(true), {1, 1})), at({}));
  EXPECT_EQ(router.on_packet(0, view(arm), at({})).decision, kForward);
  // An old word is none.
  EXPECT_EQ(router.on_packet(0, view(arm), at(std::chrono::seconds(4))).decision, kNotHil);
}

TEST(RouterInterlock, AVehicleThatCameBackAsAnotherPeerIsJudgedByItsNewHeartbeats) {
  HilWords words;
  const auto in_hil = packet(heartbeat_of(true), {1, 1});
  const auto arm = packet(arming(1), {255, 190});
  const auto permits = [&](base::RunTime now) {
    return words.permits(1, view(arm), {1, 1}, false, now);
  };
  words.on_packet({.link = 1, .peer = 7}, view(in_hil), at({}));
  EXPECT_TRUE(permits(at({})));
  const auto soon = at(std::chrono::seconds(5));
  words.on_packet({.link = 1, .peer = 8}, view(in_hil), soon);
  EXPECT_FALSE(permits(soon));  // the first one may still be there
  const auto later = at(std::chrono::seconds(70));
  for (std::uint32_t peer = 9; peer < 9 + 2 * HilWords::kMostOnALink; ++peer) {
    const auto now = later + peer * std::chrono::seconds(61);
    words.on_packet({.link = 1, .peer = peer}, view(in_hil), now);
    EXPECT_TRUE(permits(now)) << peer;
  }
}

TEST(RouterInterlock, ARecordedDisarmDropsNoVehicleThatIsArmed) {
  using mavlink::common::MavModeFlag;
  const auto plan = guarded(2);
  plan->recordings = bit(0);
  Router router(plan, mav::public_table());
  const auto disarm = packet(command_to(1, 1), {255, 190});
  const auto say = [&](MavModeFlag flags) {
    Heartbeat message = heartbeat_of(false);
    message.base_mode = flags;
    router.on_packet(1, view(packet(message, {1, 1})), at({}));
  };
  say(MavModeFlag::kCustomModeEnabled);
  EXPECT_EQ(router.on_packet(0, view(disarm), at({})).decision, kForward);
  say(MavModeFlag::kCustomModeEnabled | MavModeFlag::kSafetyArmed);
  EXPECT_EQ(router.on_packet(0, view(disarm), at({})).decision, kNotHil);
  say(MavModeFlag::kHilEnabled | MavModeFlag::kSafetyArmed);
  EXPECT_EQ(router.on_packet(0, view(disarm), at({})).decision, kForward);
}

TEST(RouterInterlock, APersonsDisarmStopsAVehicleThatIsArmed) {
  using mavlink::common::MavModeFlag;
  Router router(guarded(2), mav::public_table());
  Heartbeat armed = heartbeat_of(false);
  armed.base_mode = MavModeFlag::kCustomModeEnabled | MavModeFlag::kSafetyArmed;
  router.on_packet(1, view(packet(armed, {1, 1})), at({}));
  const auto disarm = packet(command_to(1, 1), {255, 190});
  EXPECT_EQ(router.on_packet(0, view(disarm), at({})).decision, kForward);
}

TEST(RouterInterlock, AVehicleWithoutAHeartbeatIsNotInHil) {
  Router router(guarded(3), mav::public_table());
  router.on_packet(1, view(packet(mavlink::common::CommandAck{}, {1, 1})), at({}));
  EXPECT_EQ(router.on_packet(0, view(packet(arming(1), {255, 190})), at({})).decision, kNotHil);
}

TEST(RouterInterlock, AHeartbeatOnAnotherLinkDoesNotCount) {
  Router router(guarded(3), mav::public_table());
  router.on_packet(1, view(packet(heartbeat_of(false), {1, 1})), at({}));
  router.on_packet(0, view(packet(heartbeat_of(true), {1, 1})), at({}));
  EXPECT_EQ(router.on_packet(0, view(packet(arming(1), {255, 190})), at({})).held, 1);
}

TEST(RouterInterlock, ABroadcastIsHeldFromEachLinkWithAVehicleNotInHil) {
  Router router(guarded(4), mav::public_table());
  router.on_packet(1, view(packet(heartbeat_of(true), {1, 1})), at({}));
  router.on_packet(2, view(packet(heartbeat_of(false), {2, 1})), at({}));
  const Route route = router.on_packet(0, view(packet(arming(0), {255, 190})), at({}));
  EXPECT_EQ(route.to, bit(1));
  EXPECT_EQ(route.held, 2);
  EXPECT_EQ(route.decision, kForward);
}

TEST(RouterInterlock, StopsTelemetryAndOtherLinksPass) {
  Router router(guarded(3), mav::public_table());
  router.on_packet(1, view(packet(heartbeat_of(false), {1, 1})), at({}));
  const auto disarm = packet(command_to(1, 1), {255, 190});
  EXPECT_EQ(router.on_packet(0, view(disarm), at({})).decision, kForward);
  EXPECT_EQ(router.on_packet(0, view(packet(heartbeat_of(true), {3, 1})), at({})).to,
            bit(1) | bit(2));
  EXPECT_EQ(router.on_packet(2, view(packet(arming(1), {255, 190})), at({})).decision, kForward);
}

TEST(Router, AnswerFindsTheWayBack) {
  Router router = make_router(3);
  router.on_packet(0, view(packet(Heartbeat{}, {255, 190})), at({}));
  mavlink::common::CommandAck ack{.target_system = 255, .target_component = 190};
  EXPECT_EQ(router.on_packet(2, view(packet(ack, {1, 1})), at({})).to, bit(0));
}

TEST(Router, TargetOnTheSourceLinkAloneGoesNowhere) {
  Router router = make_router(2);
  router.on_packet(0, view(packet(Heartbeat{}, {1, 1})), at({}));
  EXPECT_EQ(router.on_packet(0, view(packet(command_to(1, 1), {255, 190})), at({})).to, LinkMask{});
}

TEST(Router, RoutesExpire) {
  Router router = make_router(2);
  router.on_packet(1, view(packet(Heartbeat{}, {1, 1})), at({}));
  const base::Duration later = Router::kRouteLifetime + milliseconds(1);
  router.tick(1, at(later));
  EXPECT_EQ(router.on_packet(0, view(packet(command_to(1, 1), {255, 190})), at(later)).decision,
            kNoTarget);
}

TEST(Router, KnowsAsManyLinksAsThereAreSlots) {
  Router router = make_router(kLinkSlots);
  const auto heartbeat = packet(Heartbeat{}, {1, 1});
  const Route route = router.on_packet(kMaxLinks, view(heartbeat), at({}));
  EXPECT_EQ(route.to.count(), static_cast<unsigned>(kMaxLinks));
  EXPECT_FALSE(route.to.has(kMaxLinks));
  for (const LinkId link : std::vector<LinkId>{0, 64, 128, 192}) {
    EXPECT_EQ(router.on_packet(link, view(packet(command_to(1, 1), {255, 190})), at({})).to,
              bit(kMaxLinks));
  }
}

TEST(Router, TellsWhatCasdAloneHearsFromWhatGoesOn) {
  auto plan = std::make_shared<RoutingPlan>();
  std::vector<ForwardRule> rules(3);
  rules[0].from = 0;  // its way back is missing
  rules[0].to = kLocalLink;
  rules[1].from = 1;
  rules[1].to = kLocalLink;
  rules[2].from = 1;
  rules[2].to = 0;
  plan->rules = ForwardRules(rules);
  Router router(plan, mav::public_table());
  router.on_packet(kLocalLink, view(packet(Heartbeat{}, {254, 190})), at({}));

  const Route heard = router.on_packet(0, view(packet(Heartbeat{}, {1, 1})), at({}));
  EXPECT_EQ(heard.decision, kCasdOnly);
  EXPECT_EQ(heard.to, bit(kLocalLink));
  const Route passed = router.on_packet(1, view(packet(Heartbeat{}, {255, 190})), at({}));
  EXPECT_EQ(passed.decision, kForward);
  EXPECT_EQ(passed.to, bit(kLocalLink) | bit(0));
  const Route answer = router.on_packet(0, view(packet(command_to(254, 190), {1, 1})), at({}));
  EXPECT_EQ(answer.decision, kForward);
  EXPECT_EQ(answer.to, bit(kLocalLink));
  EXPECT_EQ(router.on_packet(0, view(packet(command_to(7, 1), {1, 1})), at({})).decision,
            kNoTarget);
}

TEST(Router, NewPlanIsInForceAtTheNextPacket) {
  Router router = make_router(3);
  const auto heartbeat = packet(Heartbeat{}, {1, 1});
  router.on_packet(0, view(heartbeat), at({}));
  router.replace(all_to_all(2));
  EXPECT_EQ(router.on_packet(0, view(heartbeat), at({})).to, bit(1));
  router.replace(std::make_shared<RoutingPlan>());
  EXPECT_EQ(router.on_packet(0, view(heartbeat), at({})).decision, kNoRule);
}

TEST(Router, PacketThatComesOverBothPathsOfAGroupGoesOnOnce) {
  auto plan = all_to_all(3);
  plan->group[0] = plan->group[1] = 0;
  plan->never_back[0] = plan->never_back[1] = bit(0) | bit(1);
  Router router(plan, mav::public_table());
  const auto first = packet(Heartbeat{}, {1, 1}, 7);
  EXPECT_EQ(router.on_packet(0, view(first), at({})).to, bit(2));  // not to the twin
  EXPECT_EQ(router.on_packet(1, view(first), at(milliseconds(3))).decision, kDuplicate);
  const auto second = packet(Heartbeat{}, {1, 1}, 8);
  EXPECT_EQ(router.on_packet(1, view(second), at(milliseconds(4))).to, bit(2));
  // Both paths are known as ways to it.
  EXPECT_EQ(router.on_packet(2, view(packet(command_to(1, 1), {255, 190})), at({})).to,
            bit(0) | bit(1));
}

TEST(Router, RepetitionOverOneLinkIsNoDuplicate) {
  auto plan = all_to_all(2);
  plan->group[0] = 0;
  Router router(plan, mav::public_table());
  const auto heartbeat = packet(Heartbeat{}, {1, 1}, 7);
  EXPECT_EQ(router.on_packet(0, view(heartbeat), at({})).to, bit(1));
  EXPECT_EQ(router.on_packet(0, view(heartbeat), at(milliseconds(1))).to, bit(1));
}

TEST(Router, OldCopyIsNoDuplicate) {
  auto plan = all_to_all(3);
  plan->group[0] = plan->group[1] = 0;
  Router router(plan, mav::public_table());
  const auto heartbeat = packet(Heartbeat{}, {1, 1}, 7);
  router.on_packet(0, view(heartbeat), at({}));
  EXPECT_EQ(router.on_packet(1, view(heartbeat), at(std::chrono::seconds(11))).decision, kForward);
}

TEST(Router, APacketThatComesAgainWithinTheWindowGoesOnOnce) {
  auto plan = all_to_all(3);
  plan->duplicate_window = milliseconds(100);
  Router router(plan, mav::public_table());
  const auto heartbeat = packet(Heartbeat{}, {1, 1}, 7);
  EXPECT_EQ(router.on_packet(0, view(heartbeat), at({})).to, bit(1) | bit(2));
  EXPECT_EQ(router.on_packet(0, view(heartbeat), at(milliseconds(99))).decision, kDuplicate)
      << "a far end that sends everything back";
  EXPECT_EQ(router.on_packet(1, view(heartbeat), at(milliseconds(100))).decision, kDuplicate);
  EXPECT_EQ(router.on_packet(2, view(heartbeat), at(milliseconds(100))).decision, kDuplicate);
  EXPECT_EQ(router.on_packet(2, view(heartbeat), at(milliseconds(101))).decision, kForward);
  router.replace(all_to_all(3));
  EXPECT_EQ(router.on_packet(1, view(heartbeat), at(milliseconds(102))).decision, kForward);
}

TEST(Router, CasdsStationHearsSecondCopiesOfAllLinksButNotOfAGroup) {
  auto plan = all_to_all(kLocalLink + 1);
  plan->duplicate_window = milliseconds(100);
  plan->group[2] = plan->group[3] = 0;
  Router router(plan, mav::public_table());
  const auto first = packet(Heartbeat{}, {1, 1}, 7);
  router.on_packet(0, view(first), at({}));
  EXPECT_EQ(router.on_packet(1, view(first), at({})).to, bit(kLocalLink));
  const auto second = packet(Heartbeat{}, {1, 1}, 8);
  router.on_packet(2, view(second), at({}));
  EXPECT_TRUE(router.on_packet(3, view(second), at({})).to.empty());
}

TEST(Router, AGroupKeepsItsWindowBesideThatOfAllLinks) {
  auto plan = all_to_all(4);
  plan->duplicate_window = milliseconds(10);
  plan->group[0] = plan->group[1] = 0;
  Router router(plan, mav::public_table());
  const auto heartbeat = packet(Heartbeat{}, {1, 1}, 7);
  EXPECT_EQ(router.on_packet(2, view(heartbeat), at({})).decision, kForward);
  EXPECT_EQ(router.on_packet(0, view(heartbeat), at(milliseconds(5))).decision, kDuplicate);
  EXPECT_EQ(router.on_packet(1, view(heartbeat), at(milliseconds(300))).decision, kDuplicate);
  EXPECT_EQ(router.on_packet(2, view(heartbeat), at(milliseconds(320))).decision, kForward);
}

TEST(Router, TellsWhichLinksARateRuleTookAway) {
  auto plan = all_to_all(2);
  ForwardRule thinned;
  thinned.from = 0;
  thinned.to = 2;
  thinned.rates = {{.message_id = 0, .every = 2}};
  ForwardRule whole;
  whole.from = 0;
  whole.to = 1;
  plan->rules = ForwardRules(std::vector{thinned, whole});
  Router router(plan, mav::public_table());
  const auto heartbeat = packet(Heartbeat{}, {1, 1});
  EXPECT_EQ(router.on_packet(0, view(heartbeat), at({})).thinned, LinkMask{});
  const Route second = router.on_packet(0, view(heartbeat), at({}));
  EXPECT_EQ(second.thinned, bit(2));
  EXPECT_EQ(second.to, bit(1));
  EXPECT_EQ(second.decision, kForward);
}

/// The rules of the routing guide and of our topology, written as slowly and plainly as they read.
struct PlainRouter {
  std::vector<ForwardRule> rules;
  std::map<LinkId, std::set<mav::Source>> heard;
  std::map<LinkId, int> group;                                 ///< links that are in one
  std::set<std::pair<int, std::vector<std::uint8_t>>> passed;  ///< packets that came into a group

  LinkMask on_packet(LinkId from, std::uint32_t id, mav::Source source, mav::Source target,
                     std::span<const std::uint8_t> bytes) {
    heard[from].insert(source);
    if (group.contains(from) &&
        !passed.insert({group[from], {bytes.begin(), bytes.end()}}).second) {
      return {};
    }
    LinkMask to;
    for (const ForwardRule& rule : rules) {
      if (rule.from != from || rule.to == from) continue;
      if (group.contains(from) && group.contains(rule.to) && group[from] == group[rule.to])
        continue;
      if (allows(rule, id, source) && wants(rule.to, target)) to.add(rule.to);
    }
    return to;
  }
  static bool contains(const auto& list, auto value) {
    return std::find(list.begin(), list.end(), value) != list.end();
  }
  static bool allows(const ForwardRule& rule, std::uint32_t id, mav::Source source) {
    if (rule.allow && !contains(*rule.allow, id)) return false;
    if (contains(rule.block, id)) return false;
    if (!rule.allow_systems.empty() && !contains(rule.allow_systems, source.system)) return false;
    if (contains(rule.block_systems, source.system)) return false;
    if (!rule.allow_components.empty() && !contains(rule.allow_components, source.component)) {
      return false;
    }
    return !contains(rule.block_components, source.component);
  }
  bool wants(LinkId link, mav::Source target) const {
    if (target.system == 0) return true;
    const auto found = heard.find(link);
    if (found == heard.end()) return false;
    return std::any_of(found->second.begin(), found->second.end(), [&](mav::Source one) {
      return one.system == target.system &&
             (target.component == 0 || one.component == target.component);
    });
  }
};

class RandomTopology {
 public:
  explicit RandomTopology(unsigned seed) : random_(seed) {}

  unsigned below(unsigned limit) { return static_cast<unsigned>(random_() % limit); }
  std::uint8_t small_id() { return static_cast<std::uint8_t>(1 + below(4)); }
  std::uint32_t message() { return below(2) == 0 ? 0 : 76; }  // HEARTBEAT, COMMAND_LONG

  ForwardRule rule(LinkId from, LinkId to) {
    ForwardRule result;
    result.from = from;
    result.to = to;
    if (below(3) == 0) result.allow = std::vector<std::uint32_t>{message()};
    if (below(4) == 0) result.block = {message()};
    if (below(5) == 0) result.allow_systems = {small_id(), small_id()};
    if (below(5) == 0) result.block_systems = {small_id()};
    if (below(5) == 0) result.allow_components = {small_id(), small_id()};
    if (below(5) == 0) result.block_components = {small_id()};
    return result;
  }

 private:
  std::mt19937 random_;
};

TEST(Router, AgreesWithThePlainRulesOnRandomTopologies) {
  for (unsigned seed = 1; seed <= 60; ++seed) {
    RandomTopology any(seed);
    const unsigned links = 2 + any.below(10);
    const unsigned stride = seed % 2 == 0 ? 1 : 22;  // in one word of a LinkMask, or in all
    const auto slot = [stride](unsigned nth) { return static_cast<LinkId>(nth * stride); };
    PlainRouter plain;
    auto plan = std::make_shared<RoutingPlan>();
    for (unsigned from = 0; from < links; ++from) {
      plan->never_back[slot(from)] = bit(slot(from));
      for (unsigned to = 0; to < links; ++to) {
        if (any.below(3) != 0) plain.rules.push_back(any.rule(slot(from), slot(to)));
      }
    }
    plan->rules = ForwardRules(plain.rules);
    for (unsigned link = 0; link < links; ++link) {
      if (any.below(2) != 0) continue;
      plain.group[slot(link)] = plan->group[slot(link)] = static_cast<std::int16_t>(any.below(2));
    }
    for (const auto& [link, group] : plain.group) {
      for (const auto& [other, its_group] : plain.group) {
        if (group == its_group) plan->never_back[link].add(other);
      }
    }
    Router router(plan, mav::public_table());
    for (unsigned i = 0; i < 500; ++i) {
      const LinkId from = slot(any.below(links));
      const mav::Source source{any.small_id(), any.small_id()};
      const bool addressed = any.below(2) == 0;
      const mav::Source target{static_cast<std::uint8_t>(any.below(5)),
                               static_cast<std::uint8_t>(any.below(5))};
      auto command = command_to(target.system, target.component);
      command.param1 = static_cast<float>(i);  // no two packets are the same
      Heartbeat heartbeat{.custom_mode = i};
      const auto sequence = static_cast<std::uint8_t>(i);
      const auto sent =
          addressed ? packet(command, source, sequence) : packet(heartbeat, source, sequence);
      const auto arrives = [&](LinkId link) {
        const LinkMask expected = plain.on_packet(link, addressed ? 76 : 0, source,
                                                  addressed ? target : mav::Source{}, sent.view());
        EXPECT_EQ(router.on_packet(link, view(sent), at(milliseconds(i))).to, expected)
            << "seed " << seed << " packet " << i;
      };
      arrives(from);
      // Over the other paths of its group as well, or not.
      for (const auto& [twin, group] : plain.group) {
        const bool redundant = plain.group.contains(from) && group == plain.group[from];
        if (redundant && twin != from && any.below(2) == 0) arrives(twin);
      }
    }
  }
}

}  // namespace
}  // namespace cas::casd::test
