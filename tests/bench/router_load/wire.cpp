// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/router_load/wire.hpp"

#include <cstring>

namespace router_load {
namespace {

struct CrcTable {
  uint16_t t[256];
  CrcTable() {
    for (int i = 0; i < 256; ++i) {
      uint16_t c = uint16_t(i);
      for (int k = 0; k < 8; ++k) c = (c & 1) ? uint16_t((c >> 1) ^ 0x8408) : uint16_t(c >> 1);
      t[i] = c;
    }
  }
} const g_crc;

template <class T>
void put(uint8_t* p, T v) {
  memcpy(p, &v, sizeof v);
}
template <class T>
T get(const uint8_t* p) {
  T v;
  memcpy(&v, p, sizeof v);
  return v;
}
float pat(uint32_t seq, uint32_t i) {
  return float(int16_t((seq * 2654435761u + i * 40503u) >> 13)) * 0.03125f;
}

}  // namespace

FlowDef g_flow[N_FLOW] = {
    {"sim.HIL_SENSOR", 107, 51, 1, true}, {"sim.HIL_GPS", 113, 51, 1, true},
    {"sim.HEARTBEAT", 0, 51, 1, true},    {"fc.HIL_CONTROLS", 91, 1, 1, false},
    {"fc.HEARTBEAT", 0, 1, 1, false},
};

uint16_t crc_x25(const uint8_t* p, size_t n, uint8_t extra) {
  uint16_t c = 0xFFFF;
  for (size_t i = 0; i < n; ++i) c = uint16_t((c >> 8) ^ g_crc.t[(c ^ p[i]) & 0xFF]);
  return uint16_t((c >> 8) ^ g_crc.t[(c ^ extra) & 0xFF]);
}
int crc_extra_of(uint32_t id) {  // messages the bench sends, and a few that routers inject
  switch (id) {
    case 0:
      return 50;
    case 2:
      return 137;
    case 4:
      return 237;
    case 20:
      return 214;
    case 66:
      return 148;
    case 76:
      return 152;
    case 91:
      return 63;
    case 93:
      return 47;
    case 107:
      return 108;
    case 111:
      return 34;
    case 113:
      return 124;
    default:
      return -1;
  }
}

size_t build_payload(uint32_t id, uint32_t seq, uint64_t ts, uint8_t* p) {
  switch (id) {
    case 0:
      put(p, seq);
      p[4] = 2;
      p[5] = 12;
      p[6] = 0x20;
      p[7] = 4;
      p[8] = 3;
      return 9;
    case 107:
      put(p, ts);
      for (uint32_t i = 0; i < 13; ++i) put(p + 8 + 4 * i, pat(seq, i));
      put(p + 60, seq);
      p[64] = 0;
      return 65;
    case 113:
      put(p, ts);
      put(p + 8, seq);
      put(p + 12, seq ^ 0x5A5A5A5Au);
      put(p + 16, seq * 7u);
      for (uint32_t i = 0; i < 7; ++i) put(p + 20 + 2 * i, uint16_t(seq * 31u + i));
      p[34] = 3;
      p[35] = 10;
      p[36] = 0;
      put(p + 37, uint16_t(0));  // fix, satellites, id, yaw
      return 39;
    case 91:
      put(p, ts);
      for (uint32_t i = 0; i < 4; ++i) put(p + 8 + 4 * i, pat(seq, i));
      put(p + 24, float(seq & 0xFFFF));
      put(p + 28, float(seq >> 16));
      for (uint32_t i = 6; i < 8; ++i) put(p + 8 + 4 * i, pat(seq, i));
      p[40] = 1;
      p[41] = 1;
      return 42;
    case 93:
      put(p, ts);
      put(p + 8, uint64_t(seq) | (uint64_t(1) << 40));
      for (uint32_t i = 0; i < 16; ++i) put(p + 16 + 4 * i, pat(seq, i));
      p[80] = 0x81;
      return 81;
    default:
      return 0;
  }
}
bool read_seq(uint32_t id, const uint8_t* p, uint32_t& seq, uint64_t& ts) {
  ts = 0;
  switch (id) {
    case 0:
      seq = get<uint32_t>(p);
      return true;
    case 107:
      ts = get<uint64_t>(p);
      seq = get<uint32_t>(p + 60);
      return true;
    case 113:
      ts = get<uint64_t>(p);
      seq = get<uint32_t>(p + 8);
      return true;
    case 91: {
      ts = get<uint64_t>(p);
      float lo = get<float>(p + 24), hi = get<float>(p + 28);
      if (!(lo >= 0 && lo < 65536 && hi >= 0 && hi < 65536)) return false;
      seq = uint32_t(lo) | (uint32_t(hi) << 16);
      return true;
    }
    case 93:
      ts = get<uint64_t>(p);
      seq = uint32_t(get<uint64_t>(p + 8));
      return true;
    default:
      return false;
  }
}
size_t build_frame(uint32_t id, uint8_t sysid, uint8_t compid, uint8_t wire_seq, uint32_t seq,
                   uint64_t ts, uint8_t* out) {
  size_t n = build_payload(id, seq, ts, out + 10);
  while (n > 1 && out[10 + n - 1] == 0) --n;  // MAVLink 2 trailing-zero truncation
  out[0] = 0xFD;
  out[1] = uint8_t(n);
  out[2] = 0;
  out[3] = 0;
  out[4] = wire_seq;
  out[5] = sysid;
  out[6] = compid;
  out[7] = uint8_t(id);
  out[8] = uint8_t(id >> 8);
  out[9] = uint8_t(id >> 16);
  uint16_t c = crc_x25(out + 1, 9 + n, uint8_t(crc_extra_of(id)));
  out[10 + n] = uint8_t(c);
  out[11 + n] = uint8_t(c >> 8);
  return n + 12;
}

}  // namespace router_load
