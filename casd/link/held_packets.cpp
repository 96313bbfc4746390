// SPDX-License-Identifier: BSD-3-Clause
#include "casd/link/held_packets.hpp"

#include <algorithm>
#include <optional>
#include <vector>

namespace cas::casd {
namespace {

using Bytes = std::vector<std::uint8_t>;

std::optional<Bytes> first_packet(Parser& parser, std::span<const std::uint8_t> bytes) {
  std::optional<Bytes> first;
  parser.feed(bytes, [&](const mav::PacketView& packet) {
    if (!first) first.emplace(packet.bytes.begin(), packet.bytes.end());
  });
  return first;
}

}  // namespace

bool holds_packets(const Parser& parser) {
  Parser probe = parser;
  bool any = false;
  probe.flush([&](const mav::PacketView&) { any = true; });
  return any;
}

bool ends_with_packet(const Parser& parser) {
  Parser probe = parser;
  std::optional<std::uint64_t> skipped;
  probe.flush([&](const mav::PacketView&) { skipped = probe.stats().skipped_bytes; });
  return skipped == probe.stats().skipped_bytes;
}

bool begins_anew(const Parser& parser, std::span<const std::uint8_t> bytes) {
  Parser alone = make_parser();
  const std::optional<Bytes> whole = first_packet(alone, bytes);
  const bool at_front = whole && whole->size() <= bytes.size() &&
                        std::ranges::equal(*whole, bytes.first(whole->size()));
  if (!at_front) return false;
  Parser joined = parser;
  const std::optional<Bytes> completed = first_packet(joined, bytes);
  return !completed || *completed == *whole;
}

}  // namespace cas::casd
