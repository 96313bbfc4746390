// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/router_load/phase.hpp"

#include <thread>
#include <vector>

#include "tests/bench/router_load/send.hpp"
#include "tests/bench/router_load/state.hpp"

namespace router_load {
namespace {

void tx_run(const Phase& ph, double seconds) {
  g_txstop = false;
  int64_t t_end = now_ns() + int64_t(seconds * 1e9);
  std::vector<std::thread> th;
  if (ph.flood_down)
    th.emplace_back(tx_flood, SIM_SENSOR, SIM_HB, t_end);
  else {
    std::vector<Item> v{{SIM_HB, 1, 0}};
    if (ph.down > 0) v.push_back({SIM_SENSOR, ph.down, 0});
    if (ph.gps > 0) v.push_back({SIM_GPS, ph.gps, 0});
    th.emplace_back(tx_paced, v, t_end);
  }
  if (ph.flood_up)
    th.emplace_back(tx_flood, FC_CTRL, FC_HB, t_end);
  else {
    std::vector<Item> v{{FC_HB, 1, 0}};
    if (ph.up > 0) v.push_back({FC_CTRL, ph.up, 0});
    th.emplace_back(tx_paced, v, t_end);
  }
  int64_t next = now_ns() + 500000000, t0 = now_ns();
  bool dropped = false, back = false;
  while (now_ns() < t_end) {
    sleep_ns(5000000);
    int64_t t = now_ns();
    if (t >= next) {
      heartbeats_from_clients();
      next = t + 1000000000;
    }
    if (o.hangup_at >= 0 && g_measure) {
      if (!dropped && t - t0 > int64_t(o.hangup_at * 1e9)) {
        g_swap = 1;
        dropped = true;
      }
      if (dropped && !back &&
          t - t0 > int64_t(o.hangup_at * 1e9) + int64_t(o.hangup_ms) * 1000000) {
        g_swap = 2;
        back = true;
      }
    }
  }
  g_txstop = true;
  for (auto& x : th) x.join();
}

}  // namespace

Out run_phase(const Phase& ph) {
  if (o.warmup > 0) tx_run(ph, o.warmup);
  sleep_ns(100000000);
  Out r;
  {
    std::lock_guard<std::mutex> k(g_mu);
    for (auto& l : g_link) {
      for (auto& p : l->path) p.reset();
      l->frames = l->bytes = l->crc_bad = l->garbage = l->payload_bad = l->other = l->foreign_seq =
          0;
    }
    for (int i = 0; i < N_FLOW; ++i) g_base[i] = g_seq[i];
    g_txfail = 0;
    g_txlate = 0;
    g_measure = true;
  }
  r.drops0 = udp_drops(o.sim_router);
  r.a = sample(o.pid);
  int64_t t0 = now_ns();
  tx_run(ph, ph.seconds);
  r.wall = double(now_ns() - t0) / 1e9;
  sleep_ns(int64_t(o.drain_ms) * 1000000);
  r.b = sample(o.pid);
  r.alive = alive(o.pid);
  r.drops1 = udp_drops(o.sim_router);
  std::lock_guard<std::mutex> k(g_mu);
  g_measure = false;
  for (int i = 0; i < N_FLOW; ++i) r.sent[i] = g_seq[i] - g_base[i];
  return r;
}

}  // namespace router_load
