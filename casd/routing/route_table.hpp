// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <vector>

#include "base/time/clock.hpp"
#include "casd/packet/link_mask.hpp"
#include "mavlink_gen/runtime/packet.hpp"

namespace cas::casd {

/// Whether the sender of this message may be silent for mav::services::kHighLatencyTimeout
/// afterwards, as behind a satellite: HIGH_LATENCY and HIGH_LATENCY2 come about once a minute. The
/// same silence holds for the vehicle in casd's station, for its route and for the peer that brings
/// it.
constexpr bool comes_rarely(std::uint32_t message_id) {
  return message_id == 234 || message_id == 235;
}
/// The silence that ends a route or a peer. @param rarely  it has sent such a message
base::Duration silence_of(base::Duration usual, bool rarely);

/// Learns on which of 64 links each system and component was heard, and forgets those that fall
/// silent. The peers of a server link are links to it, too.
///
/// `learn` and `expire` for one link belong to one thread at a time; `links_to` may be called from
/// any thread. Two links may hear the same system and component (simulator and controller may share
/// an id): an addressed packet then goes to both, apart from where it came from.
class RouteTable {
 public:
  /// @param lifetime  silence after which a route is forgotten
  explicit RouteTable(base::Duration lifetime);

  /// Notes that `link` hears `source`. @return false when the link has too many ids already
  /// @param rarely  by a message that comes_rarely(): the route lives longer from now on
  bool learn(std::uint8_t link, mav::Source source, base::RunTime now, bool rarely = false);
  /// Forgets what `link` has not heard for the lifetime. @return how many ids were forgotten
  int expire(std::uint8_t link, base::RunTime now);
  /// Forgets all that was heard on `link`.
  void forget(std::uint8_t link);

  /// Links on which the target was heard. System 0: every link; component 0: any component of it.
  SlotMask links_to(mav::Source target) const {
    if (target.system == 0) return ~SlotMask{0};
    const Row* row = rows_[target.system].load(std::memory_order_acquire);
    if (row == nullptr) return 0;
    const auto& cell = target.component == 0 ? row->any : row->by_component[target.component];
    return cell.load(std::memory_order_relaxed);
  }

  /// Ids that one link may announce: more than any real network has, few enough to bound memory.
  static constexpr std::size_t kMaxIdsPerLink = 512;

 private:
  struct Heard {
    mav::Source source;
    base::RunTime last;
    bool rarely = false;
  };
  struct PerLink {
    std::vector<Heard> heard;
    std::size_t newest = 0;  ///< where the last packet's id was found: almost always the next one's
  };
  // One row per system: links by component, then links of the system as a whole.
  struct Row {
    std::array<std::atomic<SlotMask>, 256> by_component{};
    std::atomic<SlotMask> any{0};
  };

  Row& row_of(std::uint8_t system);
  void set(std::uint8_t link, mav::Source source);
  void clear(std::uint8_t link, mav::Source source);

  base::Duration lifetime_;
  std::array<PerLink, kSlots> links_;
  std::array<std::atomic<Row*>, 256> rows_{};
  std::array<std::unique_ptr<Row>, 256> owned_rows_;
  std::atomic_flag growing_ = ATOMIC_FLAG_INIT;
};

}  // namespace cas::casd
