// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/router_load/parse.hpp"

#include <algorithm>
#include <cstring>

namespace router_load {
namespace {

void on_frame(Link& l, size_t li, const uint8_t* f, int64_t t) {
  ++l.frames;
  uint32_t id = uint32_t(f[7]) | uint32_t(f[8]) << 8 | uint32_t(f[9]) << 16;
  int fl = -1;
  for (int i = 0; i < N_FLOW; ++i)
    if (g_flow[i].msgid == id && g_flow[i].sysid == f[5] && g_flow[i].compid == f[6]) fl = i;
  if (fl < 0) {
    ++l.other;
    return;
  }
  uint8_t p[256] = {0}, want[256] = {0};
  memcpy(p, f + 10, f[1]);
  uint32_t seq;
  uint64_t ts;
  if (!read_seq(id, p, seq, ts)) {
    ++l.payload_bad;
    return;
  }
  size_t n = build_payload(id, seq, ts, want);
  if (memcmp(p, want, n)) {
    ++l.payload_bad;
    return;
  }
  bool prim = (g_flow[fl].from_sim && li == L_FC) || (!g_flow[fl].from_sim && li == L_SIM);
  if (prim) {
    g_prim[size_t(fl)].fetch_add(1, std::memory_order_relaxed);
    if (int64_t b = g_back_at.load(std::memory_order_relaxed)) {
      auto& rec = li == L_FC ? g_rec_down : g_rec_up;
      if (li == L_FC && ts != 0) {
        if (int64_t(ts) < b) ++g_back_stale;
        g_back_oldest = std::max<int64_t>(g_back_oldest, t - int64_t(ts));
      }
      if (!rec.load(std::memory_order_relaxed) && (li == L_FC || int64_t(ts) > b)) rec.store(t);
    }
  }
  if (!g_measure.load(std::memory_order_relaxed)) return;
  if (seq < g_base[fl] || seq >= g_seq[fl].load(std::memory_order_relaxed)) {
    ++l.foreign_seq;
    return;
  }
  if (!l.path[fl]) l.path[fl] = std::make_unique<PathStat>();
  l.path[fl]->add(g_base[fl], seq, ts, t);
}

}  // namespace

size_t parse(Link& l, size_t li, const uint8_t* p, size_t n, int64_t t, bool whole) {
  size_t i = 0;
  while (i < n) {
    if (p[i] == 0xFD) {
      if (n - i < 12) {
        if (whole) {
          l.garbage += n - i;
          return n;
        }
        return i;
      }
      size_t len = p[i + 1], tot = len + 12 + ((p[i + 2] & 1) ? 13 : 0);
      uint32_t id = uint32_t(p[i + 7]) | uint32_t(p[i + 8]) << 8 | uint32_t(p[i + 9]) << 16;
      int ex = crc_extra_of(id);
      if (ex < 0 || (p[i + 2] & ~1)) {
        ++l.garbage;
        ++i;
        continue;
      }
      if (n - i < tot) {
        if (whole) {
          l.garbage += n - i;
          return n;
        }
        return i;
      }
      uint16_t c = crc_x25(p + i + 1, 9 + len, uint8_t(ex));
      if (c == (uint16_t(p[i + 10 + len]) | uint16_t(p[i + 11 + len]) << 8)) {
        on_frame(l, li, p + i, t);
        i += tot;
      } else {
        ++l.crc_bad;
        ++l.garbage;
        ++i;
      }
    } else if (p[i] == 0xFE) {  // MAVLink 1 (router heartbeats)
      if (n - i < 8) {
        if (whole) {
          l.garbage += n - i;
          return n;
        }
        return i;
      }
      size_t len = p[i + 1], tot = len + 8;
      int ex = crc_extra_of(p[i + 5]);
      if (ex < 0) {
        ++l.garbage;
        ++i;
        continue;
      }
      if (n - i < tot) {
        if (whole) {
          l.garbage += n - i;
          return n;
        }
        return i;
      }
      uint16_t c = crc_x25(p + i + 1, 5 + len, uint8_t(ex));
      if (c == (uint16_t(p[i + 6 + len]) | uint16_t(p[i + 7 + len]) << 8)) {
        ++l.frames;
        ++l.other;
        i += tot;
      } else {
        ++l.garbage;
        ++i;
      }
    } else {
      ++l.garbage;
      ++i;
    }
  }
  return i;
}

}  // namespace router_load
