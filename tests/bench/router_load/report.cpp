// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/router_load/report.hpp"

#include <cstdarg>
#include <cstdio>

#include "tests/bench/router_load/state.hpp"

namespace router_load {

void app(std::string& s, const char* fmt, ...) {
  char b[1024];
  va_list ap;
  va_start(ap, fmt);
  vsnprintf(b, sizeof b, fmt, ap);
  va_end(ap);
  s += b;
}
std::string esc(const std::string& s) {
  std::string r;
  for (char c : s) {
    if (c == '"' || c == '\\') r += '\\';
    if (uint8_t(c) >= 0x20) r += c;
  }
  return r;
}

std::string report(const Phase& ph, const Out& r, bool table) {
  std::string j;
  auto us = [](double ns) { return ns / 1000.0; };
  app(j,
      "{\"wall_s\":%.3f,\"down_hz\":%.0f,\"up_hz\":%.0f,\"flood_down\":%s,\"flood_up\":%s,"
      "\"window\":%d,\"tx_fail\":%llu,\"tx_late\":%llu,\"paths\":[",
      r.wall, ph.down, ph.up, ph.flood_down ? "true" : "false", ph.flood_up ? "true" : "false",
      o.window, (unsigned long long)g_txfail, (unsigned long long)g_txlate);
  if (table)
    fprintf(stderr, "%-16s %-6s %9s %9s %8s %5s %5s %9s | latency us %8s %8s %8s %9s %9s\n", "flow",
            "to", "sent", "deliv", "lost", "dup", "reord", "msg/s", "p50", "p90", "p99", "p99.9",
            "max");
  bool first = true;
  uint64_t deliv_all = 0, prim_all = 0, sent_all = 0;
  for (int f = 0; f < N_FLOW; ++f) {
    sent_all += r.sent[f];
    for (size_t i = 0; i < g_link.size(); ++i) {
      Link& l = *g_link[i];
      bool prim = (g_flow[f].from_sim && i == L_FC) || (!g_flow[f].from_sim && i == L_SIM);
      PathStat* p = l.path[f].get();
      if (!p && !(prim && r.sent[f])) continue;
      static PathStat none;
      if (!p) p = &none;
      deliv_all += p->delivered;
      if (prim) prim_all += p->delivered;
      double dur = p->delivered > 1 ? double(p->t_last - p->t_first) / 1e9 : 0,
             rate = dur > 0 ? double(p->delivered - 1) / dur : 0;
      uint64_t lost = r.sent[f] - std::min<uint64_t>(r.sent[f], p->delivered);
      app(j,
          "%s{\"flow\":\"%s\",\"to\":\"%s\",\"primary\":%s,\"sent\":%llu,\"delivered\":%llu,"
          "\"lost\":%llu,\"dup\":%llu,\"reordered\":%llu,\"rate_hz\":%.1f",
          first ? "" : ",", g_flow[f].name, l.name.c_str(), prim ? "true" : "false",
          (unsigned long long)r.sent[f], (unsigned long long)p->delivered, (unsigned long long)lost,
          (unsigned long long)p->dup, (unsigned long long)p->reord, rate);
      if (p->h.n)
        app(j,
            ",\"latency_us\":{\"min\":%.1f,\"mean\":%.1f,\"p50\":%.1f,\"p90\":%.1f,\"p99\":%.1f,"
            "\"p999\":%.1f,\"max\":%.1f}",
            us(double(p->h.mn)), us(p->h.sum / double(p->h.n)), us(p->h.q(.5)), us(p->h.q(.9)),
            us(p->h.q(.99)), us(p->h.q(.999)), us(double(p->h.mx)));
      j += "}";
      first = false;
      if (table && (g_flow[f].msgid || p->delivered < r.sent[f]))
        fprintf(stderr,
                "%-16s %-6s %9llu %9llu %8llu %5llu %5llu %9.0f |            %8.1f %8.1f %8.1f "
                "%9.1f %9.1f\n",
                g_flow[f].name, l.name.c_str(), (unsigned long long)r.sent[f],
                (unsigned long long)p->delivered, (unsigned long long)lost,
                (unsigned long long)p->dup, (unsigned long long)p->reord, rate, us(p->h.q(.5)),
                us(p->h.q(.9)), us(p->h.q(.99)), us(p->h.q(.999)), us(double(p->h.mx)));
    }
  }
  j += "],\"links\":[";
  for (size_t i = 0; i < g_link.size(); ++i) {
    Link& l = *g_link[i];
    app(j,
        "%s{\"name\":\"%s\",\"frames\":%llu,\"bytes\":%llu,\"crc_bad\":%llu,\"garbage_bytes\":%llu,"
        "\"payload_bad\":%llu,\"other_frames\":%llu,\"stale_frames\":%llu}",
        i ? "," : "", l.name.c_str(), (unsigned long long)l.frames, (unsigned long long)l.bytes,
        (unsigned long long)l.crc_bad, (unsigned long long)l.garbage,
        (unsigned long long)l.payload_bad, (unsigned long long)l.other,
        (unsigned long long)l.foreign_seq);
    if (table && (l.crc_bad || l.garbage || l.payload_bad || l.foreign_seq))
      fprintf(stderr, "  ! %s: crc_bad=%llu garbage_bytes=%llu payload_bad=%llu stale=%llu\n",
              l.name.c_str(), (unsigned long long)l.crc_bad, (unsigned long long)l.garbage,
              (unsigned long long)l.payload_bad, (unsigned long long)l.foreign_seq);
  }
  j += "]";
  if (r.b.ok && r.alive) {
    double ns = r.b.run_ns - r.a.run_ns;
    app(j,
        ",\"router\":{\"alive\":%s,\"cpu_s\":%.4f,\"user_s\":%.2f,\"sys_s\":%.2f,\"cpu_percent\":%."
        "2f,\"cpu_us_per_msg\":%.2f,\"cpu_us_per_delivery\":%.2f,"
        "\"ctx_voluntary\":%llu,\"ctx_involuntary\":%llu,\"ctx_per_msg\":%.2f,\"rss_kb\":%ld,\"hwm_"
        "kb\":%ld,\"threads\":%d}",
        r.alive ? "true" : "false", ns / 1e9, r.b.user - r.a.user, r.b.sys - r.a.sys,
        ns / 1e7 / r.wall, prim_all ? ns / 1e3 / double(prim_all) : 0,
        deliv_all ? ns / 1e3 / double(deliv_all) : 0, (unsigned long long)(r.b.vcs - r.a.vcs),
        (unsigned long long)(r.b.ics - r.a.ics),
        prim_all ? double(r.b.vcs - r.a.vcs) / double(prim_all) : 0, r.b.rss_kb, r.b.hwm_kb,
        r.b.threads);
    if (table)
      fprintf(stderr,
              "router: cpu %.3f s (%.1f %%), %.2f us/msg, %.2f us/delivery, %.2f voluntary "
              "switches/msg, rss %ld kB, %d threads%s\n",
              ns / 1e9, ns / 1e7 / r.wall, prim_all ? ns / 1e3 / double(prim_all) : 0,
              deliv_all ? ns / 1e3 / double(deliv_all) : 0,
              prim_all ? double(r.b.vcs - r.a.vcs) / double(prim_all) : 0, r.b.rss_kb, r.b.threads,
              r.alive ? "" : ", DEAD");
  } else if (o.pid > 0) {
    app(j, ",\"router\":{\"alive\":%s}", r.alive ? "true" : "false");
    if (table)
      fprintf(stderr, "router: %s\n", r.alive ? "alive" : "DEAD (it exited during the run)");
  }
  if (r.drops1 >= 0) {
    app(j, ",\"router_udp_rcvbuf_drops\":%ld", r.drops1 - std::max(0L, r.drops0));
    if (table && r.drops1 > r.drops0)
      fprintf(stderr,
              "kernel dropped %ld datagrams at the router's UDP port %d (receive buffer full)\n",
              r.drops1 - std::max(0L, r.drops0), o.sim_router);
  }
  if (o.hangup_at >= 0) {
    int64_t b = g_back_at, d = g_rec_down, u = g_rec_up;
    app(j,
        ",\"hangup\":{\"recovered_down\":%s,\"recovered_up\":%s,\"recover_down_ms\":%.1f,\"recover_"
        "up_ms\":%.1f,\"stale\":%lld,\"oldest_ms\":%.1f}",
        d ? "true" : "false", u ? "true" : "false", d ? double(d - b) / 1e6 : -1,
        u ? double(u - b) / 1e6 : -1, (long long)g_back_stale, double(g_back_oldest) / 1e6);
    if (table)
      fprintf(stderr,
              "hangup: sim->fc %s (%.0f ms), fc->sim %s (%.0f ms) after the PTY came back\n",
              d ? "recovered" : "NOT recovered", d ? double(d - b) / 1e6 : -1,
              u ? "recovered" : "NOT recovered", u ? double(u - b) / 1e6 : -1);
  }
  app(j, ",\"sent_total\":%llu,\"delivered_total\":%llu}", (unsigned long long)sent_all,
      (unsigned long long)deliv_all);
  return j;
}

}  // namespace router_load
