// SPDX-License-Identifier: BSD-3-Clause
#include "casd/duplicate_filter.hpp"

#include <cstring>

namespace cas::casd {
namespace {

// Mixes eight bytes at a time (multiply and fold, as in wyhash); the constant is odd and has its
// bits spread evenly.
std::uint64_t hash_of(std::span<const std::uint8_t> bytes) {
  constexpr std::uint64_t kMultiplier = 0x9E3779B97F4A7C15ULL;
  std::uint64_t hash = bytes.size() * kMultiplier;
  while (!bytes.empty()) {
    std::uint64_t word = 0;
    const std::size_t take = bytes.size() < sizeof word ? bytes.size() : sizeof word;
    std::memcpy(&word, bytes.data(), take);
    hash = (hash ^ word) * kMultiplier;
    hash ^= hash >> 29U;
    bytes = bytes.subspan(take);
  }
  return hash;
}

}  // namespace

DuplicateFilter::DuplicateFilter(base::Duration window) : window_(window) {}

bool DuplicateFilter::is_duplicate(LinkId from, std::span<const std::uint8_t> bytes,
                                   base::RunTime now) {
  const std::uint64_t hash = hash_of(bytes);
  const std::scoped_lock lock(mutex_);
  if (entries_.empty()) entries_.resize(kEntries);
  Entry& entry = entries_[hash % kEntries];
  const bool known = entry.from != kNoLink && entry.hash == hash && now - entry.seen <= window_;
  if (known && entry.from != from) return true;
  entry = {hash, now, from};
  return false;
}

}  // namespace cas::casd
