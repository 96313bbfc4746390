// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "base/time/clock.hpp"
#include "casd/packet/link_mask.hpp"
#include "casd/packet/packet_info.hpp"
#include "casd/station/services.hpp"
#include "mavlink_gen/runtime/packet.hpp"

namespace cas::casd {

/// A place on the wire's terms.
struct HomeAmsl {
  double lat_deg = 0;
  double lon_deg = 0;
  double alt_m = 0;                  ///< above mean sea level
  double x_m = 0, y_m = 0, z_m = 0;  ///< of home in the vehicle's local frame N
};

/// Another autopilot that uses a vehicle's system id.
struct Rival {
  mav::Source source;
  Origin from;
  base::RunTime at{};  ///< of its newest HEARTBEAT
};

/// State of one vehicle, from its own messages, and its paths. Pure.
///
/// A vehicle is an autopilot at one place: a link, and on a server link one peer of it. The links
/// of a group are one place, with at most one peer on each link.
class VehicleState final : public mav::services::VehicleState {
 public:
  VehicleState(mav::Source source, const Origin& origin, base::RunTime now)
      : mav::services::VehicleState(source, now), group_(origin.group), ways_{{origin.path, now}} {}

  /// Whether a packet from there comes from this vehicle's place.
  bool is_at(const Origin& from, base::RunTime now) const;
  /// Takes in one packet of this vehicle's autopilot, from its place.
  void on_packet(const Origin& from, const mav::PacketView& packet, base::RunTime now);
  /// Forgets the ways over these links. @return whether any way is left
  bool forget(const LinkMask& links);

  /// The link that it is heard on: with redundant links the first, while it carries packets.
  LinkId link() const { return ways_.front().path.link; }
  Origin origin() const { return {ways_.front().path, group_}; }
  /// All ways to it.
  std::vector<Path> paths() const;
  /// Whether this link is a way to it, and no other link has heard it lately.
  bool hangs_on(LinkId link, base::RunTime now) const;

  /// Another autopilot uses this vehicle's system id.
  void on_rival(const Rival& rival) { rival_ = rival; }
  /// The rival that spoke last, unless it is silent by now.
  std::optional<Rival> rival(base::RunTime now) const;

  /// From HOME_POSITION, or from GLOBAL_POSITION_INT and LOCAL_POSITION_NED together.
  std::optional<HomeAmsl> home() const;

 private:
  struct Way {
    Path path;
    base::RunTime at{};  ///< of the newest packet
  };

  void heard_over(const Origin& from, base::RunTime now);

  std::int16_t group_;
  std::vector<Way> ways_;  ///< the one in use first; never empty while the vehicle is known
  std::optional<Rival> rival_;
};

}  // namespace cas::casd
