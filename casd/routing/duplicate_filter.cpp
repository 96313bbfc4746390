// SPDX-License-Identifier: BSD-3-Clause
#include "casd/routing/duplicate_filter.hpp"

#include <algorithm>
#include <cstring>
#include <random>

namespace cas::casd {
namespace {

std::uint64_t random_key() {
  std::random_device device;
  return std::uint64_t{device()} << 32U | device();
}

}  // namespace

DuplicateFilter::DuplicateFilter() : key_(random_key()) {}

bool DuplicateFilter::is_duplicate(LinkId from, const mav::PacketView& packet, base::RunTime now,
                                   base::Duration window) {
  const base::MutexLock lock(mutex_);
  Entry* const entry = find_or_add(from, packet, now, window);
  if (entry == nullptr) return false;
  if (entry->from != from) return true;
  entry->seen = now;
  return false;
}

bool DuplicateFilter::came_before(LinkId from, const mav::PacketView& packet, base::RunTime now,
                                  base::Duration window) {
  const base::MutexLock lock(mutex_);
  return find_or_add(from, packet, now, window) != nullptr;
}

DuplicateFilter::Entry* DuplicateFilter::find_or_add(LinkId from, const mav::PacketView& packet,
                                                     base::RunTime now, base::Duration window) {
  const std::uint64_t hash = hash_of(packet.bytes);
  Set& set = sender(packet.source, now).by_sequence[packet.sequence];
  Entry* oldest = &set.front();
  for (Entry& entry : set) {
    const bool same = entry.from != kNoLink && entry.hash == hash;
    if (same && now - entry.seen <= window) return &entry;
    if (entry.seen < oldest->seen) oldest = &entry;
  }
  *oldest = {hash, now, from};
  return nullptr;
}

DuplicateFilter::Sender& DuplicateFilter::sender(mav::Source source, base::RunTime now) {
  const auto found = std::find_if(senders_.begin(), senders_.end(),
                                  [&](const auto& each) { return each->source == source; });
  if (found != senders_.end()) {
    (*found)->last = now;
    return **found;
  }
  if (senders_.size() < kMaxSenders) senders_.push_back(std::make_unique<Sender>());
  const auto silent =
      std::min_element(senders_.begin(), senders_.end(),
                       [](const auto& a, const auto& b) { return a->last < b->last; });
  **silent = Sender{.source = source, .last = now, .by_sequence = {}};
  return **silent;
}

// Mixes eight bytes at a time; each step can be undone, so packets that differ in one word differ.
std::uint64_t DuplicateFilter::hash_of(std::span<const std::uint8_t> bytes) const {
  constexpr std::uint64_t kMultiplier = 0x9E3779B97F4A7C15ULL;
  std::uint64_t hash = key_ + bytes.size();
  while (!bytes.empty()) {
    std::uint64_t word = 0;
    const std::size_t take = std::min(bytes.size(), sizeof word);
    std::memcpy(&word, bytes.data(), take);
    hash = (hash ^ word) * kMultiplier;
    hash ^= hash >> 32U;
    bytes = bytes.subspan(take);
  }
  return hash * kMultiplier ^ hash >> 29U;
}

}  // namespace cas::casd
