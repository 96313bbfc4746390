// SPDX-License-Identifier: BSD-3-Clause
#include "casd/packet/setpoint_stream.hpp"

#include <array>
#include <limits>
#include <optional>

#include "mavlink/common/rc_channels_override.hpp"
#include "mavlink_gen/runtime/codec.hpp"

namespace cas::casd {
namespace {

using mavlink::common::RcChannelsOverride;

constexpr std::uint16_t kLeave = std::numeric_limits<std::uint16_t>::max();

// The channels that a RC_CHANNELS_OVERRIDE names, as bits. Of channel 9 and up 0 leaves them, too.
std::uint32_t named_channels(std::span<const std::uint8_t> bytes) {
  const std::optional<RcChannelsOverride> rc =
      mav::decode<RcChannelsOverride>(mav::view_packet(bytes));
  if (!rc) return 0;
  constexpr std::size_t kFirstOfLater = 8;
  const std::array channels{rc->chan1_raw,  rc->chan2_raw,  rc->chan3_raw,  rc->chan4_raw,
                            rc->chan5_raw,  rc->chan6_raw,  rc->chan7_raw,  rc->chan8_raw,
                            rc->chan9_raw,  rc->chan10_raw, rc->chan11_raw, rc->chan12_raw,
                            rc->chan13_raw, rc->chan14_raw, rc->chan15_raw, rc->chan16_raw,
                            rc->chan17_raw, rc->chan18_raw};
  std::uint32_t named = 0;
  for (std::size_t i = 0; i < channels.size(); ++i) {
    const bool left = channels[i] == kLeave || (i >= kFirstOfLater && channels[i] == 0);
    if (!left) named |= std::uint32_t{1} << i;
  }
  return named;
}

}  // namespace

bool same_stream(const PacketInfo& a, const PacketInfo& b) {
  const bool same_way = a.from_group >= 0 ? a.from_group == b.from_group
                                          : a.from == b.from && a.from_serial == b.from_serial;
  return same_way && a.message_id == b.message_id && a.source == b.source && a.target == b.target &&
         a.to_serial == b.to_serial;
}

bool replaces(const PacketInfo& info, std::span<const std::uint8_t> newer,
              std::span<const std::uint8_t> older) {
  if (info.message_id != RcChannelsOverride::kId) return true;
  return (named_channels(older) & ~named_channels(newer)) == 0;
}

}  // namespace cas::casd
