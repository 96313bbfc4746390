// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "base/os/mutex.hpp"
#include "casd/packet/link_id.hpp"

namespace cas::casd {

/// A set of 64 slots, bit i for slot i: the peers of a server link, or 64 links of a LinkMask.
using SlotMask = std::uint64_t;
inline constexpr int kSlots = 64;

constexpr SlotMask slot_bit(std::uint8_t slot) { return SlotMask{1} << slot; }

/// Calls visit(slot) for each slot of the set, the lowest first. `visit` may require a lock
/// (CAS_REQUIRES), which its caller holds.
template <class Visit>
constexpr void for_each_slot(SlotMask slots, Visit&& visit)
    CAS_THREAD_SAFETY(no_thread_safety_analysis) {
  for (; slots != 0; slots &= slots - 1) visit(static_cast<std::uint8_t>(std::countr_zero(slots)));
}

/// A set of links, in words of 64 slots. The first word holds casd's own station and the first 63
/// links, so that code that visits only the words in use visits one word in a topology of that
/// size.
class LinkMask {
 public:
  static constexpr std::size_t kWords = 4;
  static constexpr std::size_t word_of(LinkId link) { return link / kSlots; }
  static constexpr std::uint8_t slot_of(LinkId link) { return link % kSlots; }
  static constexpr LinkId link_of(std::size_t word, std::uint8_t slot) {
    return static_cast<LinkId>(word * kSlots + slot);
  }

  SlotMask word(std::size_t index) const { return words_[index]; }
  void set_word(std::size_t index, SlotMask links) { words_[index] = links; }

  constexpr void add(LinkId link) { words_[word_of(link)] |= slot_bit(slot_of(link)); }
  constexpr void remove(LinkId link) { words_[word_of(link)] &= ~slot_bit(slot_of(link)); }
  constexpr bool has(LinkId link) const {
    return (words_[word_of(link)] & slot_bit(slot_of(link))) != 0;
  }
  constexpr bool empty() const {
    return words_[0] == 0 && (words_[1] | words_[2] | words_[3]) == 0;
  }
  constexpr unsigned count() const {
    unsigned links = 0;
    for (const SlotMask word : words_) links += static_cast<unsigned>(std::popcount(word));
    return links;
  }
  /// The lowest slot that is not in the set, which is not full.
  constexpr LinkId first_missing() const {
    std::size_t word = 0;
    while (words_[word] == ~SlotMask{0}) ++word;
    return link_of(word, static_cast<std::uint8_t>(std::countr_one(words_[word])));
  }
  /// Calls visit(link) for each link, the lowest first.
  template <class Visit>
  constexpr void for_each(Visit&& visit) const {
    for (std::size_t word = 0; word < kWords; ++word) {
      for_each_slot(words_[word], [&](std::uint8_t slot) { visit(link_of(word, slot)); });
    }
  }

  constexpr LinkMask& operator|=(const LinkMask& other) {
    for (std::size_t i = 0; i < kWords; ++i) words_[i] |= other.words_[i];
    return *this;
  }
  constexpr LinkMask& operator&=(const LinkMask& other) {
    for (std::size_t i = 0; i < kWords; ++i) words_[i] &= other.words_[i];
    return *this;
  }
  /// Takes the links of `other` out.
  constexpr LinkMask& operator-=(const LinkMask& other) {
    for (std::size_t i = 0; i < kWords; ++i) words_[i] &= ~other.words_[i];
    return *this;
  }
  friend constexpr LinkMask operator|(LinkMask a, const LinkMask& b) { return a |= b; }
  friend constexpr LinkMask operator-(LinkMask a, const LinkMask& b) { return a -= b; }
  friend constexpr bool operator==(const LinkMask&, const LinkMask&) = default;

 private:
  std::array<SlotMask, kWords> words_{};
};

/// The set of this link alone.
constexpr LinkMask bit(LinkId link) {
  LinkMask one;
  one.add(link);
  return one;
}

}  // namespace cas::casd
