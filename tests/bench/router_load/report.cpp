// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/router_load/report.hpp"

#include <algorithm>
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

namespace {

using Count = unsigned long long;

double us(double ns) { return ns / 1000.0; }
const char* word(bool yes) { return yes ? "true" : "false"; }

/// Frames over all paths, and over the primary ones.
struct Totals {
  uint64_t sent = 0, delivered = 0, primary = 0;
};

/// One flow as one link received it.
struct PathFigures {
  const char* flow;
  const char* to;
  bool primary;
  uint64_t sent, lost;
  double rate;
  const PathStat& stat;
};

void print_path_heads() {
  fprintf(stderr, "%-16s %-6s %9s %9s %8s %5s %5s %9s | latency us %8s %8s %8s %9s %9s\n", "flow",
          "to", "sent", "deliv", "lost", "dup", "reord", "msg/s", "p50", "p90", "p99", "p99.9",
          "max");
}

void print_path(const PathFigures& p) {
  fprintf(stderr,
          "%-16s %-6s %9llu %9llu %8llu %5llu %5llu %9.0f |            %8.1f %8.1f %8.1f "
          "%9.1f %9.1f\n",
          p.flow, p.to, Count(p.sent), Count(p.stat.delivered), Count(p.lost), Count(p.stat.dup),
          Count(p.stat.reord), p.rate, us(p.stat.h.q(.5)), us(p.stat.h.q(.9)), us(p.stat.h.q(.99)),
          us(p.stat.h.q(.999)), us(double(p.stat.h.mx)));
}

std::string path_json(const PathFigures& p) {
  std::string j;
  app(j,
      "{\"flow\":\"%s\",\"to\":\"%s\",\"primary\":%s,\"sent\":%llu,\"delivered\":%llu,"
      "\"lost\":%llu,\"dup\":%llu,\"reordered\":%llu,\"rate_hz\":%.1f",
      p.flow, p.to, word(p.primary), Count(p.sent), Count(p.stat.delivered), Count(p.lost),
      Count(p.stat.dup), Count(p.stat.reord), p.rate);
  if (p.stat.h.n)
    app(j,
        ",\"latency_us\":{\"min\":%.1f,\"mean\":%.1f,\"p50\":%.1f,\"p90\":%.1f,\"p99\":%.1f,"
        "\"p999\":%.1f,\"max\":%.1f}",
        us(double(p.stat.h.mn)), us(p.stat.h.sum / double(p.stat.h.n)), us(p.stat.h.q(.5)),
        us(p.stat.h.q(.9)), us(p.stat.h.q(.99)), us(p.stat.h.q(.999)), us(double(p.stat.h.mx)));
  return j + "}";
}

double rate_of(const PathStat& p) {
  const double seconds = p.delivered > 1 ? double(p.t_last - p.t_first) / 1e9 : 0;
  return seconds > 0 ? double(p.delivered - 1) / seconds : 0;
}

std::string paths_json(const Out& r, bool table, Totals& totals) {
  static const PathStat none;
  std::string j;
  if (table) print_path_heads();
  for (int f = 0; f < N_FLOW; ++f) {
    totals.sent += r.sent[f];
    for (size_t i = 0; i < g_link.size(); ++i) {
      const Link& l = *g_link[i];
      const bool prim = (g_flow[f].from_sim && i == L_FC) || (!g_flow[f].from_sim && i == L_SIM);
      if (!l.path[f] && !(prim && r.sent[f])) continue;
      const PathStat& p = l.path[f] ? *l.path[f] : none;
      totals.delivered += p.delivered;
      if (prim) totals.primary += p.delivered;
      const uint64_t lost = r.sent[f] - std::min<uint64_t>(r.sent[f], p.delivered);
      const PathFigures figures{g_flow[f].name, l.name.c_str(), prim, r.sent[f],
                                lost,           rate_of(p),     p};
      j += (j.empty() ? "" : ",") + path_json(figures);
      if (table && (g_flow[f].msgid || p.delivered < r.sent[f])) print_path(figures);
    }
  }
  return j;
}

std::string links_json(bool table) {
  std::string j;
  for (const auto& link : g_link) {
    const Link& l = *link;
    app(j,
        "%s{\"name\":\"%s\",\"frames\":%llu,\"bytes\":%llu,\"crc_bad\":%llu,\"garbage_bytes\":%llu,"
        "\"payload_bad\":%llu,\"other_frames\":%llu,\"stale_frames\":%llu}",
        j.empty() ? "" : ",", l.name.c_str(), Count(l.frames), Count(l.bytes), Count(l.crc_bad),
        Count(l.garbage), Count(l.payload_bad), Count(l.other), Count(l.foreign_seq));
    if (table && (l.crc_bad || l.garbage || l.payload_bad || l.foreign_seq))
      fprintf(stderr, "  ! %s: crc_bad=%llu garbage_bytes=%llu payload_bad=%llu stale=%llu\n",
              l.name.c_str(), Count(l.crc_bad), Count(l.garbage), Count(l.payload_bad),
              Count(l.foreign_seq));
  }
  return j;
}

/// What the router's process used.
void add_router(std::string& j, const Out& r, bool table, const Totals& totals) {
  if (!r.b.ok || !r.alive) {
    if (o.pid <= 0) return;
    app(j, ",\"router\":{\"alive\":%s}", word(r.alive));
    if (table)
      fprintf(stderr, "router: %s\n", r.alive ? "alive" : "DEAD (it exited during the run)");
    return;
  }
  const double ns = r.b.run_ns - r.a.run_ns;
  const auto each = [](double sum, uint64_t count) { return count ? sum / double(count) : 0; };
  const double us_msg = each(us(ns), totals.primary), us_delivery = each(us(ns), totals.delivered);
  const double switches = each(double(r.b.vcs - r.a.vcs), totals.primary);
  app(j,
      ",\"router\":{\"alive\":true,\"cpu_s\":%.4f,\"user_s\":%.2f,\"sys_s\":%.2f,"
      "\"cpu_percent\":%.2f,\"cpu_us_per_msg\":%.2f,\"cpu_us_per_delivery\":%.2f,"
      "\"ctx_voluntary\":%llu,\"ctx_involuntary\":%llu,\"ctx_per_msg\":%.2f,\"rss_kb\":%ld,"
      "\"hwm_kb\":%ld,\"threads\":%d}",
      ns / 1e9, r.b.user - r.a.user, r.b.sys - r.a.sys, ns / 1e7 / r.wall, us_msg, us_delivery,
      Count(r.b.vcs - r.a.vcs), Count(r.b.ics - r.a.ics), switches, r.b.rss_kb, r.b.hwm_kb,
      r.b.threads);
  if (table)
    fprintf(stderr,
            "router: cpu %.3f s (%.1f %%), %.2f us/msg, %.2f us/delivery, %.2f voluntary "
            "switches/msg, rss %ld kB, %d threads\n",
            ns / 1e9, ns / 1e7 / r.wall, us_msg, us_delivery, switches, r.b.rss_kb, r.b.threads);
}

/// What the kernel dropped before the router read it.
void add_drops(std::string& j, const Out& r, bool table) {
  if (r.drops1 < 0) return;
  const long drops = r.drops1 - std::max(0L, r.drops0);
  app(j, ",\"router_udp_rcvbuf_drops\":%ld", drops);
  if (table && r.drops1 > r.drops0)
    fprintf(stderr,
            "kernel dropped %ld datagrams at the router's UDP port %d (receive buffer full)\n",
            drops, o.sim_router);
}

/// How the router came through --hangup-at.
void add_hangup(std::string& j, bool table) {
  if (o.hangup_at < 0) return;
  const int64_t back = g_back_at, down = g_rec_down, up = g_rec_up;
  const double down_ms = down ? double(down - back) / 1e6 : -1;
  const double up_ms = up ? double(up - back) / 1e6 : -1;
  app(j,
      ",\"hangup\":{\"recovered_down\":%s,\"recovered_up\":%s,\"recover_down_ms\":%.1f,"
      "\"recover_up_ms\":%.1f,\"stale\":%lld,\"oldest_ms\":%.1f}",
      word(down != 0), word(up != 0), down_ms, up_ms, (long long)g_back_stale,
      double(g_back_oldest) / 1e6);
  if (table)
    fprintf(stderr, "hangup: sim->fc %s (%.0f ms), fc->sim %s (%.0f ms) after the PTY came back\n",
            down ? "recovered" : "NOT recovered", down_ms, up ? "recovered" : "NOT recovered",
            up_ms);
}

}  // namespace

std::string report(const Phase& ph, const Out& r, bool table) {
  std::string j;
  app(j,
      "{\"wall_s\":%.3f,\"down_hz\":%.0f,\"up_hz\":%.0f,\"flood_down\":%s,\"flood_up\":%s,"
      "\"window\":%d,\"tx_fail\":%llu,\"tx_late\":%llu,\"paths\":[",
      r.wall, ph.down, ph.up, word(ph.flood_down), word(ph.flood_up), o.window, Count(g_txfail),
      Count(g_txlate));
  Totals totals;
  j += paths_json(r, table, totals) + "],\"links\":[" + links_json(table) + "]";
  add_router(j, r, table, totals);
  add_drops(j, r, table);
  add_hangup(j, table);
  app(j, ",\"sent_total\":%llu,\"delivered_total\":%llu}", Count(totals.sent),
      Count(totals.delivered));
  return j;
}

}  // namespace router_load
