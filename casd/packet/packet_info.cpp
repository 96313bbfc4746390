// SPDX-License-Identifier: BSD-3-Clause
#include "casd/packet/packet_info.hpp"

#include "casd/packet/hil_stamp.hpp"

namespace cas::casd {

PacketInfo inspect(const mav::PacketView& packet, const mav::MessageTable& table) {
  PacketInfo info;
  info.message_id = packet.message_id;
  info.source = packet.source;
  info.traffic = classify(packet.message_id);
  info.hil_time_usec = hil_time_usec(packet).value_or(0);
  if (const mav::MessageInfo* known = table.find(packet.message_id)) {
    info.target = mav::target_of(packet, *known);
  }
  return info;
}

}  // namespace cas::casd
