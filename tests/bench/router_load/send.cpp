// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/router_load/send.hpp"

#include <errno.h>
#include <poll.h>
#include <pthread.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>

#include "tests/bench/router_load/state.hpp"

namespace router_load {

bool send_flow(Flow f) {
  uint8_t b[300];
  const FlowDef& d = g_flow[f];
  uint32_t seq = g_seq[f].load(std::memory_order_relaxed);
  uint8_t ws = d.from_sim ? g_wire_sim.fetch_add(1) : g_wire_fc.fetch_add(1);
  int64_t ts = now_ns();
  size_t n = build_frame(d.msgid, d.sysid, d.compid, ws, seq, uint64_t(ts), b);
  g_seq[f].store(seq + 1,
                 std::memory_order_relaxed);  // before the write: the receiver may be faster
  if (d.from_sim) {
    if (!o.sim_router && !o.direct && !g_sim_dst_ok) return false;
    if (sendto(g_sim_fd, b, n, 0, reinterpret_cast<sockaddr*>(&g_sim_dst), sizeof g_sim_dst) !=
        ssize_t(n)) {
      ++g_txfail;
      return false;
    }
    return true;
  }
  std::lock_guard<std::mutex> k(g_fc_mu);
  size_t off = 0;
  while (off < n) {
    int fd = g_fc_tx;
    if (fd < 0) {
      ++g_txfail;
      return false;
    }
    ssize_t r = write(fd, b + off, n - off);
    if (r > 0) {
      off += size_t(r);
      continue;
    }
    if (r < 0 && errno != EAGAIN && errno != EINTR) {
      ++g_txfail;
      return false;
    }
    if (g_txstop && off == 0) return false;  // never leave half a frame behind while running
    pollfd p{fd, POLLOUT, 0};
    poll(&p, 1, 20);
    if (g_txstop && now_ns() - ts > 300000000) return false;
  }
  return true;
}

void tx_paced(std::vector<Item> items, int64_t t_end) {
  prctl(PR_SET_TIMERSLACK, 1);
  pthread_setname_np(pthread_self(), "rl-tx");
  go_rt();
  int64_t t0 = now_ns();
  for (auto& i : items) i.due = t0;
  while (!g_txstop) {
    auto it = std::min_element(items.begin(), items.end(),
                               [](const Item& a, const Item& b) { return a.due < b.due; });
    if (it->due >= t_end) break;
    int64_t t = now_ns();
    if (t >= t_end) break;
    if (it->due > t)
      sleep_until(it->due);
    else if (t - it->due > 100000000) {
      it->due = t;
      ++g_txlate;
    }  // do not repay a long stall as one burst
    if (g_txstop) break;
    send_flow(it->f);
    it->due += int64_t(1e9 / it->hz);
  }
}
void tx_flood(Flow f, Flow hb, int64_t t_end) {
  prctl(PR_SET_TIMERSLACK, 1);
  pthread_setname_np(pthread_self(), "rl-flood");
  uint64_t base_sent = g_seq[f], base_recv = g_prim[f];
  int64_t next_hb = now_ns(), stuck = 0;
  uint64_t last_recv = 0;
  while (!g_txstop) {
    int64_t t = now_ns();
    if (t >= t_end) break;
    if (t >= next_hb) {
      send_flow(hb);
      next_hb = t + 1000000000;
    }
    if (o.window) {
      uint64_t s = g_seq[f] - base_sent, r = g_prim[f] - base_recv;
      if (s >= r + uint64_t(o.window)) {
        if (r != last_recv) {
          last_recv = r;
          stuck = t;
        } else if (stuck && t - stuck > 100000000) {
          base_sent = g_seq[f];
          base_recv = g_prim[f];
          stuck = 0;
        } else if (!stuck)
          stuck = t;
        sleep_ns(10000);
        continue;
      }
    }
    send_flow(f);
  }
}

void heartbeats_from_clients() {
  static uint8_t ws = 0;
  std::lock_guard<std::mutex> k(g_mu);
  for (size_t i = 2; i < g_link.size(); ++i) {
    Link& l = *g_link[i];
    uint8_t b[300];
    size_t n = build_frame(0, uint8_t(255 - (i - 2) % 190), 190, ws, 0, 0, b);
    if (l.stream) {
      if (!l.stalled || ws < 3) (void)!send(l.fd, b, n, MSG_DONTWAIT | MSG_NOSIGNAL);
    } else {
      sockaddr_in a = o.gcs_router ? lo_addr(o.gcs_router) : l.peer;
      if (o.gcs_router || l.has_peer)
        sendto(l.fd, b, n, MSG_DONTWAIT, reinterpret_cast<sockaddr*>(&a), sizeof a);
    }
  }
  ++ws;
}

}  // namespace router_load
