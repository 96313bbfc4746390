// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "base/os/mutex.hpp"
#include "base/time/clock.hpp"
#include "casd/packet/link_id.hpp"
#include "mavlink_gen/runtime/packet.hpp"

namespace cas::casd {

/// Finds packets that come a second time. May be called from several threads.
///
/// A redundant path may be seconds late. It brings copies in the order in which the packets came
/// first, so one that is behind its path's place in that order is no copy: the sender has said the
/// same again, 256 packets later. Nor is what comes over a path a second time: senders that do not
/// count repeat themselves with the same bytes.
///
/// Each sender has memory of its own, indexed by the packet's sequence number, so neither other
/// senders nor its own next packets push an entry out: a second copy is found up to 8 x 256 packets
/// later. The sender that has been silent longest makes room for a new one. Two packets are the
/// same when their size and a 64-bit hash over all bytes agree; the hash has a secret key.
class DuplicateFilter {
 public:
  static constexpr std::size_t kMaxSenders = 256;
  /// How late a path may be.
  static constexpr base::Duration kLatest = std::chrono::seconds(10);
  /// How far packets of a path may overtake each other.
  static constexpr base::Duration kDisorder = std::chrono::milliseconds(100);

  DuplicateFilter();

  /// @param window  how much later a second copy comes in any order
  /// @return true when another link brought this packet; a packet that comes again over the same
  ///         link is no duplicate: its sender repeated it
  bool is_duplicate(LinkId from, const mav::PacketView& packet, base::RunTime now,
                    base::Duration window);
  /// The same, whichever link brought it.
  bool came_before(LinkId from, const mav::PacketView& packet, base::RunTime now,
                   base::Duration window);

 private:
  static constexpr std::size_t kWays = 8;
  struct Entry {
    std::uint64_t hash = 0;
    base::RunTime seen;
    LinkId from = kNoLink;
    LinkId copied = kNoLink;  ///< the link that brought a copy last since `seen`
  };
  using Set = std::array<Entry, kWays>;
  /// When another link first brought the newest copy that came over this one.
  struct Place {
    LinkId link = kNoLink;
    base::RunTime first_seen;
  };
  struct Sender {
    mav::Source source;
    base::RunTime last;
    std::array<Set, 256> by_sequence;
    std::vector<Place> places;

    Place& place_of(LinkId link);
  };
  /// The entry of a packet of the window; of a new one, which is remembered, nullptr.
  Entry* find_or_add(Sender& sender, LinkId from, const mav::PacketView& packet, base::RunTime now,
                     base::Duration window) CAS_REQUIRES(mutex_);
  Sender& sender_of(mav::Source source, base::RunTime now) CAS_REQUIRES(mutex_);
  std::uint64_t hash_of(std::span<const std::uint8_t> bytes) const;

  const std::uint64_t key_;
  base::Mutex mutex_;
  std::vector<std::unique_ptr<Sender>> senders_ CAS_GUARDED_BY(mutex_);
};

}  // namespace cas::casd
