// SPDX-License-Identifier: BSD-3-Clause
#include "casd/queue/newest_setpoints.hpp"

#include <algorithm>
#include <utility>

#include "casd/packet/setpoint_stream.hpp"

namespace cas::casd {

void NewestSetpoints::push(const PacketInfo& info, std::span<const std::uint8_t> bytes,
                           const OnDrop& on_drop) {
  std::size_t place = waiting_.size();
  bool something_stays = false;
  for (std::size_t i = 0; i < waiting_.size();) {
    if (!same_stream(waiting_[i].info, info)) {
      ++i;
    } else if (!replaces(info, bytes, waiting_[i].bytes)) {
      something_stays = true;
      ++i;
    } else {
      if (on_drop) on_drop(waiting_[i].info, DropCause::kSuperseded);
      place = std::min(place, i);
      waiting_.erase(waiting_.begin() + static_cast<std::ptrdiff_t>(i));
    }
  }
  if (waiting_.size() == kMaxWaiting) make_room(info, on_drop);
  // An older setpoint must not leave after a newer one.
  if (something_stays || place > waiting_.size()) place = waiting_.size();
  waiting_.insert(waiting_.begin() + static_cast<std::ptrdiff_t>(place),
                  Waiting{info, {bytes.begin(), bytes.end()}});
}

QueuedPacket NewestSetpoints::pop() {
  popped_ = std::move(waiting_.front());
  waiting_.erase(waiting_.begin());
  return {popped_.info, popped_.bytes};
}

// Drops the oldest that came over the same way, or the oldest of all if there is none.
void NewestSetpoints::make_room(const PacketInfo& info, const OnDrop& on_drop) {
  auto oldest = std::find_if(waiting_.begin(), waiting_.end(), [&](const Waiting& each) {
    return each.info.from == info.from && each.info.from_serial == info.from_serial;
  });
  if (oldest == waiting_.end()) oldest = waiting_.begin();
  if (on_drop) on_drop(oldest->info, DropCause::kQueueFull);
  waiting_.erase(oldest);
}

}  // namespace cas::casd
