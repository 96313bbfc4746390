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
  Sender& sender = sender_of(packet.source, now);
  Entry* const entry = find_or_add(sender, from, packet, now, std::max(window, kLatest));
  if (entry == nullptr) return false;
  if (entry->from != from) {
    base::RunTime& reached = sender.place_of(from).first_seen;
    const bool late = entry->copied != from && entry->seen + kDisorder >= reached;
    if (now - entry->seen <= window || late) {
      reached = std::max(reached, entry->seen);
      entry->copied = from;
      return true;
    }
    entry->from = from;
  }
  entry->seen = now;
  entry->copied = kNoLink;
  return false;
}

bool DuplicateFilter::came_before(LinkId from, const mav::PacketView& packet, base::RunTime now,
                                  base::Duration window) {
  const base::MutexLock lock(mutex_);
  return find_or_add(sender_of(packet.source, now), from, packet, now, window) != nullptr;
}

DuplicateFilter::Entry* DuplicateFilter::find_or_add(Sender& sender, LinkId from,
                                                     const mav::PacketView& packet,
                                                     base::RunTime now, base::Duration window) {
  const std::uint64_t hash = hash_of(packet.bytes);
  Set& set = sender.by_sequence[packet.sequence];
  Entry* oldest = &set.front();
  for (Entry& entry : set) {
    const bool same = entry.from != kNoLink && entry.hash == hash;
    if (same && now - entry.seen <= window) return &entry;
    if (entry.seen < oldest->seen) oldest = &entry;
  }
  *oldest = {hash, now, from};
  return nullptr;
}

DuplicateFilter::Place& DuplicateFilter::Sender::place_of(LinkId link) {
  const auto known = std::ranges::find(places, link, &Place::link);
  return known != places.end() ? *known : places.emplace_back(Place{link, {}});
}

DuplicateFilter::Sender& DuplicateFilter::sender_of(mav::Source source, base::RunTime now) {
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
  **silent = Sender{.source = source, .last = now, .by_sequence = {}, .places = {}};
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
