// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>

namespace router_load {

enum Flow { SIM_SENSOR, SIM_GPS, SIM_HB, FC_CTRL, FC_HB, N_FLOW };
struct FlowDef {
  const char* name;
  uint32_t msgid;
  uint8_t sysid, compid;
  bool from_sim;
};
extern FlowDef g_flow[N_FLOW];

/// X.25 checksum of a packet behind its start byte.
uint16_t crc_x25(const uint8_t* p, size_t n, uint8_t extra);
/// CRC_EXTRA of the messages that the bench sends, and of a few that routers inject; -1: another.
int crc_extra_of(uint32_t id);
/// Fills an untruncated payload, returns its length.
size_t build_payload(uint32_t id, uint32_t seq, uint64_t ts, uint8_t* p);
/// Sequence number and time of a payload. @return false when it can be none of ours
bool read_seq(uint32_t id, const uint8_t* p, uint32_t& seq, uint64_t& ts);
/// A whole packet, returns its length.
size_t build_frame(uint32_t id, uint8_t sysid, uint8_t compid, uint8_t wire_seq, uint32_t seq,
                   uint64_t ts, uint8_t* out);

}  // namespace router_load
