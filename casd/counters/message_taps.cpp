// SPDX-License-Identifier: BSD-3-Clause
#include "casd/counters/message_taps.hpp"

#include <algorithm>

namespace cas::casd {

void MessageTaps::note(const Key& key, const mav::PacketView& packet, base::RunTime now) {
  if (!mutex_.try_lock()) return;  // a look may miss a packet; the data path does not wait
  const base::MutexLock lock(mutex_, std::adopt_lock);
  const auto look =
      std::find_if(looks_.begin(), looks_.end(), [&](const Look& each) { return each.key == key; });
  if (look == looks_.end()) return;
  Sample& sample = look->sample;
  sample.size = std::min(packet.payload.size(), sample.payload.size());
  std::copy_n(packet.payload.begin(), sample.size, sample.payload.begin());
  sample.at = now;
  ++sample.count;
}

std::optional<MessageTaps::Sample> MessageTaps::look(const Key& key, base::RunTime now) {
  const base::MutexLock lock(mutex_);
  expire(now);
  const auto found =
      std::find_if(looks_.begin(), looks_.end(), [&](const Look& each) { return each.key == key; });
  if (found != looks_.end()) {
    found->asked = now;
    if (found->sample.count == 0) return std::nullopt;
    return found->sample;
  }
  if (looks_.size() < kMaxLooks) {
    looks_.push_back({.key = key, .sample = {}, .asked = now});
    watched_.fetch_or(bit_of(key.message_id), std::memory_order_relaxed);
  }
  return std::nullopt;
}

/// Stops watching messages that no client has asked for lately.
void MessageTaps::expire(base::RunTime now) {
  std::erase_if(looks_, [now](const Look& look) { return now - look.asked > kPatience; });
  std::uint64_t bits = 0;
  for (const Look& look : looks_) bits |= bit_of(look.key.message_id);
  watched_.store(bits, std::memory_order_relaxed);
}

}  // namespace cas::casd
