// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace cas::casd {

/// Why a packet did not go on.
enum class DropCause : std::uint8_t {
  // The link that was to send it did not; the first kDropCauses.
  kAge,
  kBandwidth,
  kQueueFull,
  kClosed,
  kStalled,
  kUnsignable,
  kSuperseded,
  // The router sent it nowhere; in the order of Route::Decision.
  kDuplicate,
  kNoRule,
  kNoTarget,
  kRateLimited,
  kNotHil,
  // The router never got it.
  kCrc,
  kKernel,
  kNotAccepted,
  kForeign,
  kNoMemory,
};
inline constexpr int kDropCauses = static_cast<int>(DropCause::kSuperseded) + 1;

/// Name and texts of a cause, for every program that prints it.
struct CauseWords {
  DropCause cause;
  std::string_view word;       ///< in JSON, to Prometheus and in ledgers
  std::string_view meaning;    ///< of `casctl drops`, and what to do
  std::string_view account{};  ///< in the account of a flight's packets
  bool trouble = false;        ///< the doctor warns of packets that a link drops for it
};

/// The verdict on what casd's own station alone may have: neither forwarded nor dropped.
inline constexpr std::string_view kCasdOnlyWord = "casd_only";

inline constexpr auto kCauses = std::to_array<CauseWords>({
    {DropCause::kAge, "age",
     "would have arrived too late: the line is too slow for what is sent, or stood still",
     "too old in casd's queue", true},
    {DropCause::kBandwidth, "bandwidth", "would have arrived too late under the link's max_bytes_s",
     "too old in casd's queue, under the link's max_bytes_s", true},
    {DropCause::kQueueFull, "queue_full",
     "no room in its queue: the line is too slow or stands still", "casd's queue was full", true},
    {DropCause::kClosed, "closed", "the link was away, or its network refused the packet",
     "the link was down"},
    {DropCause::kStalled, "stalled", "the peer stopped reading and was closed",
     "the peer stopped reading", true},
    {DropCause::kUnsignable, "unsignable",
     "damaged before it came here: its checksum fits no message", "casd could not sign it", true},
    {DropCause::kSuperseded, "superseded",
     "a newer setpoint of its stream took its place while it waited",
     "a newer setpoint took its place"},
    {DropCause::kDuplicate, "duplicate", "came already"},
    {DropCause::kNoRule, "no_rule", "no route lets it go anywhere (see casctl routes)"},
    {DropCause::kNoTarget, "no_target", "addressed to a system that was never heard"},
    {DropCause::kRateLimited, "rate_limited", "thinned out by a route's rates"},
    {DropCause::kNotHil, "not_hil",
     "may spin or move a vehicle that does not say it is in HIL (to_not_hil of its link)"},
    {DropCause::kCrc, "crc", "a packet with a wrong checksum: the line disturbs it"},
    {DropCause::kKernel, "kernel", "the socket's buffer was full: casd came too late"},
    {DropCause::kNotAccepted, "not_accepted", "the link takes in no such packets (accept)"},
    {DropCause::kForeign, "foreign", "no room for one more peer, or not the peer"},
    {DropCause::kNoMemory, "no_memory", "casd got no memory for it"},
});
static_assert([] {
  for (std::size_t i = 0; i < kCauses.size(); ++i) {
    if (kCauses[i].cause != static_cast<DropCause>(i)) return false;
  }
  return kCauses.back().cause == DropCause::kNoMemory;
}());

constexpr const CauseWords& words_of(DropCause cause) {
  return kCauses[static_cast<std::size_t>(cause)];
}
constexpr std::string_view to_string(DropCause cause) { return words_of(cause).word; }
/// nullptr: no cause has this word.
constexpr const CauseWords* find_cause(std::string_view word) {
  for (const CauseWords& words : kCauses) {
    if (words.word == word) return &words;
  }
  return nullptr;
}

}  // namespace cas::casd
