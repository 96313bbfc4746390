// SPDX-License-Identifier: BSD-3-Clause
#include "casd/routing/hil_words.hpp"

#include "mavlink/common/heartbeat.hpp"
#include "mavlink_gen/runtime/codec.hpp"
#include "mavlink_gen/services/vehicle_heartbeat.hpp"
#include "mavlink_gen/services/vehicle_state.hpp"

namespace cas::casd {

using mav::services::Addressee;
using mav::services::Motion;
using mav::services::motion_of;

void HilWords::on_packet(const Path& from, const mav::PacketView& packet, base::RunTime now) {
  using namespace mavlink::common;  // NOLINT: its HEARTBEAT
  const auto heartbeat = mav::decode<Heartbeat>(packet);
  if (!heartbeat || !mav::services::is_vehicle(packet.source, *heartbeat)) return;
  const base::MutexLock lock(mutex_);
  PerLink& link = links_[from.link];
  const std::pair key{packet.source, from.peer};
  if (!link.words.contains(key)) {
    std::erase_if(link.words, [now](const auto& each) {
      return each.first.second != 0 && now - each.second.at > kPeerGone;
    });
  }
  if (link.words.size() == kMostOnALink && !link.words.contains(key)) {
    link.full = true;
    return;
  }
  link.words[key] = {.hil = has(heartbeat->base_mode, MavModeFlag::kHilEnabled),
                     .at = now,
                     .addressee = mav::services::addressee_of(*heartbeat)};
}

bool HilWords::permits(LinkId to, const mav::PacketView& packet, mav::Source target, bool recorded,
                       base::RunTime now) {
  const auto stops = [recorded](Motion motion, bool armed) {
    return motion <= (recorded && armed ? Motion::kStops : Motion::kCuts);
  };
  const Motion worst = motion_of(packet, Addressee{});
  if (stops(worst, Addressee{}.armed)) return true;
  const base::MutexLock lock(mutex_);
  const auto link = links_.find(to);
  if (link == links_.end()) return worst == Motion::kMisleads;
  bool addressed = false;
  for (const auto& [sender, word] : link->second.words) {
    if (target.system != 0 && target.system != sender.first.system) continue;
    addressed = true;
    const bool in_hil = word.hil && now - word.at <= mav::services::kVehicleTimeout;
    if (!in_hil && !stops(motion_of(packet, word.addressee), word.addressee.armed)) return false;
  }
  if (link->second.full) return false;
  return addressed || worst == Motion::kMisleads;
}

void HilWords::forget(LinkId link) {
  const base::MutexLock lock(mutex_);
  links_.erase(link);
}

bool HilWords::may_move(const mav::PacketView& packet) {
  return motion_of(packet, Addressee{}) >= Motion::kMoves;
}

}  // namespace cas::casd
