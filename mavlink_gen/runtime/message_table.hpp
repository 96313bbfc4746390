// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

#include "mavlink_gen/runtime/packet.hpp"
#include "mavlink_gen/runtime/text_view.hpp"

namespace cas::mav {

/// What a receiver needs to know of a message to check it, and a router to address it.
struct MessageInfo {
  std::uint32_t id{};
  std::uint8_t crc_extra{};   ///< last byte that the checksum takes in: tells layouts apart
  std::uint8_t min_length{};  ///< bytes of payload without extensions
  std::uint8_t max_length{};  ///< bytes of payload with extensions
  std::int16_t target_system_offset{-1};     ///< in the untruncated payload, -1: no such field
  std::int16_t target_component_offset{-1};  ///< likewise
  TextView name;
};

namespace detail {

/// Slots of a hash table with open addressing that is at most half full.
constexpr std::size_t slot_count(std::size_t messages) {
  return std::bit_ceil(messages < 4 ? std::size_t{8} : messages * 2);
}

inline constexpr std::uint16_t kNoMessage = 0xFFFF;

constexpr std::size_t hash(std::uint32_t id) {
  constexpr std::uint32_t kGoldenRatio = 0x9E3779B1;  // 2^32 / 1.618..., spreads neighbours
  return (id * kGoldenRatio) >> 16U;
}

constexpr std::size_t hash(TextView name) {
  std::uint32_t value = 0x811C9DC5;  // FNV-1a, 32 bit: start and prime
  const char* characters = name.data();
  for (std::size_t i = 0, size = name.size(); i < size; ++i) {
    value = (value ^ static_cast<std::uint8_t>(characters[i])) * 0x01000193U;
  }
  return value ^ value >> 16U;
}

/// Writes into each slot the index of its message. Both arrays of slots have slot_count() elements.
/// Bare pointers: compilers evaluate this in every file that has a table.
constexpr void fill_slots(const MessageInfo* messages, std::size_t count, std::uint16_t* by_id,
                          std::uint16_t* by_name) {
  const auto slots = slot_count(count);
  for (std::size_t i = 0; i < slots; ++i) by_id[i] = by_name[i] = kNoMessage;
  for (std::size_t i = 0; i < count; ++i) {
    auto slot = hash(messages[i].id) & (slots - 1);
    while (by_id[slot] != kNoMessage) slot = (slot + 1) & (slots - 1);
    by_id[slot] = static_cast<std::uint16_t>(i);
    slot = hash(messages[i].name) & (slots - 1);
    while (by_name[slot] != kNoMessage) slot = (slot + 1) & (slots - 1);
    by_name[slot] = static_cast<std::uint16_t>(i);
  }
}

}  // namespace detail

/// Messages by id and by name. Borrows its storage: StaticMessageTable, or vectors of the caller.
class MessageTable {
 public:
  constexpr MessageTable() = default;
  constexpr MessageTable(std::span<const MessageInfo> messages,
                         std::span<const std::uint16_t> by_id,
                         std::span<const std::uint16_t> by_name)
      : messages_(messages), by_id_(by_id), by_name_(by_name) {}

  /// nullptr when the table does not hold the id.
  constexpr const MessageInfo* find(std::uint32_t id) const {
    if (by_id_.empty()) return nullptr;
    const auto mask = by_id_.size() - 1;
    for (auto slot = detail::hash(id) & mask;; slot = (slot + 1) & mask) {
      const auto index = by_id_[slot];
      if (index == detail::kNoMessage) return nullptr;
      if (messages_[index].id == id) return &messages_[index];
    }
  }

  /// By its name as in the XML; nullptr when the table does not hold it.
  constexpr const MessageInfo* find(TextView name) const {
    if (by_name_.empty()) return nullptr;
    const auto mask = by_name_.size() - 1;
    for (auto slot = detail::hash(name) & mask;; slot = (slot + 1) & mask) {
      const auto index = by_name_[slot];
      if (index == detail::kNoMessage) return nullptr;
      if (messages_[index].name == name) return &messages_[index];
    }
  }

  /// Every message, by id.
  constexpr std::span<const MessageInfo> all() const { return messages_; }

 private:
  std::span<const MessageInfo> messages_;
  std::span<const std::uint16_t> by_id_;
  std::span<const std::uint16_t> by_name_;
};

/// Storage of a table that is known when the program is compiled.
template <std::size_t n>
class StaticMessageTable {
 public:
  static_assert(n < detail::kNoMessage);

  /// @param messages  by id; they must outlive the table
  constexpr explicit StaticMessageTable(const MessageInfo (&messages)[n]) : messages_(messages) {
    detail::fill_slots(messages, n, by_id_, by_name_);
  }

  /// Borrows from this object, which must outlive the view.
  constexpr MessageTable view() const { return {{messages_, n}, by_id_, by_name_}; }

 private:
  const MessageInfo* messages_;
  std::uint16_t by_id_[detail::slot_count(n)]{};
  std::uint16_t by_name_[detail::slot_count(n)]{};
};

/// Whom a packet is for, by its target fields; 0 means everyone.
inline Source target_of(const PacketView& packet, const MessageInfo& info) {
  const auto byte_at = [&](std::int16_t offset) -> std::uint8_t {
    const auto index = static_cast<std::size_t>(offset);
    return offset < 0 || index >= packet.payload.size() ? std::uint8_t{0} : packet.payload[index];
  };
  return {byte_at(info.target_system_offset), byte_at(info.target_component_offset)};
}

}  // namespace cas::mav
