// SPDX-License-Identifier: BSD-3-Clause
#include "casd/packet/setpoint_stream.hpp"

#include <array>
#include <limits>
#include <optional>

#include "mavlink/common/manual_control.hpp"
#include "mavlink/common/rc_channels_override.hpp"
#include "mavlink/common/set_attitude_target.hpp"
#include "mavlink/common/set_position_target_global_int.hpp"
#include "mavlink/common/set_position_target_local_ned.hpp"
#include "mavlink_gen/runtime/codec.hpp"

namespace cas::casd {
namespace {

using mavlink::common::ManualControl;
using mavlink::common::RcChannelsOverride;
using mavlink::common::SetAttitudeTarget;
using mavlink::common::SetPositionTargetGlobalInt;
using mavlink::common::SetPositionTargetLocalNed;

constexpr std::uint16_t kLeave = std::numeric_limits<std::uint16_t>::max();

/// For channel 9 and up, 0 also means "no change".
bool replaces(const RcChannelsOverride& newer, const RcChannelsOverride& older) {
  const auto named_channels = [](const RcChannelsOverride& rc) {
    constexpr std::size_t kFirstOfLater = 8;
    const std::array channels{
        rc.chan1_raw,  rc.chan2_raw,  rc.chan3_raw,  rc.chan4_raw,  rc.chan5_raw,  rc.chan6_raw,
        rc.chan7_raw,  rc.chan8_raw,  rc.chan9_raw,  rc.chan10_raw, rc.chan11_raw, rc.chan12_raw,
        rc.chan13_raw, rc.chan14_raw, rc.chan15_raw, rc.chan16_raw, rc.chan17_raw, rc.chan18_raw};
    std::uint32_t named = 0;
    for (std::size_t i = 0; i < channels.size(); ++i) {
      const bool left = channels[i] == kLeave || (i >= kFirstOfLater && channels[i] == 0);
      if (!left) named |= std::uint32_t{1} << i;
    }
    return named;
  };
  return (named_channels(older) & ~named_channels(newer)) == 0;
}

/// A short press of a button must not be lost.
bool replaces(const ManualControl& newer, const ManualControl& older) {
  return newer.buttons == older.buttons && newer.buttons2 == older.buttons2;
}

/// The bits of a type mask name the fields to ignore.
template <class Target>
bool names_as_much(const Target& newer, const Target& older) {
  return (static_cast<unsigned>(newer.type_mask) & ~static_cast<unsigned>(older.type_mask)) == 0;
}

bool replaces(const SetAttitudeTarget& newer, const SetAttitudeTarget& older) {
  return names_as_much(newer, older);
}

template <class PositionTarget>
bool replaces(const PositionTarget& newer, const PositionTarget& older) {
  return newer.coordinate_frame == older.coordinate_frame && names_as_much(newer, older);
}

template <class Message>
bool replaces_as(const mav::PacketView& newer, const mav::PacketView& older) {
  const std::optional<Message> next = mav::decode<Message>(newer);
  const std::optional<Message> last = mav::decode<Message>(older);
  return !next || !last || replaces(*next, *last);
}

// SET_ACTUATOR_CONTROL_TARGET, which our dialects do not have: the group lies behind the time (8
// bytes) and eight controls (4 bytes each).
constexpr std::uint32_t kActuatorTarget = 139;
std::uint8_t actuator_group(const mav::PacketView& packet) {
  constexpr std::size_t kOffset = 8 + 8 * 4;
  return packet.payload.size() > kOffset ? packet.payload[kOffset] : 0;
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
  const mav::PacketView next = mav::view_packet(newer);
  const mav::PacketView last = mav::view_packet(older);
  switch (info.message_id) {
    case RcChannelsOverride::kId:
      return replaces_as<RcChannelsOverride>(next, last);
    case ManualControl::kId:
      return replaces_as<ManualControl>(next, last);
    case SetAttitudeTarget::kId:
      return replaces_as<SetAttitudeTarget>(next, last);
    case SetPositionTargetLocalNed::kId:
      return replaces_as<SetPositionTargetLocalNed>(next, last);
    case SetPositionTargetGlobalInt::kId:
      return replaces_as<SetPositionTargetGlobalInt>(next, last);
    case kActuatorTarget:
      return actuator_group(next) == actuator_group(last);
    default:
      return true;
  }
}

}  // namespace cas::casd
