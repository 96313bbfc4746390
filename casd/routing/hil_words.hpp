// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <utility>

#include "base/os/mutex.hpp"
#include "base/time/clock.hpp"
#include "casd/packet/packet_info.hpp"
#include "mavlink_gen/runtime/packet.hpp"
#include "mavlink_gen/services/motion.hpp"

namespace cas::casd {

/// Remembers whether the newest HEARTBEAT of each vehicle on each link has the HIL flag, and
/// decides which packets may go to a link by it. Any thread may call it.
class HilWords {
 public:
  /// Vehicles of one link; nothing that may move one goes to a link that has more.
  static constexpr std::size_t kMostOnALink = 64;
  /// Silence after which a peer of a server link counts as gone: its vehicle may be back as another
  /// peer.
  static constexpr base::Duration kPeerGone = std::chrono::seconds(60);

  /// Learns from a vehicle's HEARTBEAT; does nothing with other packets.
  void on_packet(const Path& from, const mav::PacketView& packet, base::RunTime now);
  /// Whether the packet may go to a link: it stops its target there at most, or each vehicle there
  /// that it addresses has said that it is in HIL, with its newest HEARTBEAT and lately. A link on
  /// which no such vehicle was heard gets nothing that may move one.
  /// @param recorded  it comes from a log, so that nobody sees the vehicle that it would stop: what
  ///                  cuts the motors counts as moving an armed vehicle
  bool permits(LinkId to, const mav::PacketView& packet, mav::Source target, bool recorded,
               base::RunTime now);
  void forget(LinkId link);

  /// Whether the packet may move or spin some vehicle.
  static bool may_move(const mav::PacketView& packet);

 private:
  struct Word {
    bool hil = false;
    base::RunTime at{};
    mav::services::Addressee addressee{};
  };
  struct PerLink {
    std::map<std::pair<mav::Source, std::uint32_t>, Word> words;  ///< by sender and peer
    bool full = false;
  };

  base::Mutex mutex_;
  std::map<LinkId, PerLink> links_ CAS_GUARDED_BY(mutex_);
};

}  // namespace cas::casd
