// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <vector>

namespace router_load {

struct Hist {  // log-linear, 128 steps per octave (0.8 %), exact min/max/mean
  static constexpr int SUB = 128, OCT = 36;
  std::vector<uint32_t> c = std::vector<uint32_t>(SUB * OCT, 0);
  uint64_t n = 0;
  int64_t mn = INT64_MAX, mx = 0;
  double sum = 0;
  void add(int64_t v) {
    if (v < 0) v = 0;
    ++n;
    sum += double(v);
    mn = std::min(mn, v);
    mx = std::max(mx, v);
    uint64_t u = uint64_t(v);
    size_t idx;
    if (u < SUB)
      idx = size_t(u);
    else {
      int e = 63 - __builtin_clzll(u) - 7;  // u >> e is in [128, 255]
      idx = size_t(SUB) * size_t(e + 1) + size_t((u >> e) - SUB);
    }
    ++c[std::min(idx, c.size() - 1)];
  }
  double q(double f) const {  // ns, upper edge of the bucket
    if (!n) return 0;
    uint64_t want = uint64_t(std::ceil(f * double(n))), acc = 0;
    if (want < 1) want = 1;
    for (size_t i = 0; i < c.size(); ++i) {
      acc += c[i];
      if (acc >= want) {
        if (i < size_t(SUB)) return double(i);
        size_t e = i / SUB - 1, s = i % SUB;
        return std::min(double(mx), double((uint64_t(SUB + s + 1) << e) - 1));
      }
    }
    return double(mx);
  }
};

struct PathStat {
  uint64_t delivered = 0, dup = 0, reord = 0;
  int64_t last = -1, t_first = 0, t_last = 0;
  std::vector<uint64_t> seen;
  Hist h;
  void add(uint32_t base, uint32_t seq, uint64_t ts, int64_t t) {
    size_t k = seq - base;
    if (k / 64 >= seen.size()) seen.resize(std::max<size_t>(k / 64 + 1, seen.size() * 2 + 64), 0);
    uint64_t bit = uint64_t(1) << (k % 64);
    if (seen[k / 64] & bit) {
      ++dup;
      return;
    }
    seen[k / 64] |= bit;
    if (int64_t(k) < last)
      ++reord;
    else
      last = int64_t(k);
    if (!delivered) t_first = t;
    t_last = t;
    ++delivered;
    if (ts) h.add(t - int64_t(ts));
  }
};

}  // namespace router_load
