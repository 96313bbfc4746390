// SPDX-License-Identifier: BSD-3-Clause
// router_load - measures any MAVLink router process from the outside.
//
// What it does
//   * opens a PTY pair; the router opens the slave through a symlink (--fc-link), the
//     bench holds the master and plays the flight controller ("fc");
//   * plays the simulator on a UDP socket ("sim"), N UDP ground stations ("gcs0..") and
//     M TCP clients ("tcp0.."), optionally K TCP clients that never read (--tcp-stall);
//   * sends valid MAVLink 2 frames whose payload carries a sequence number, the send time
//     (CLOCK_MONOTONIC ns, in time_usec) and a pattern derived from the sequence number;
//   * checks every received frame (CRC, payload bytes, order, duplicates) and reports per
//     path sent/delivered/lost/duplicated/reordered, one-way latency quantiles, rates, and
//     the router's CPU time, context switches and memory (from /proc/PID).
//
// Build:  g++ -std=c++20 -O2 -pthread -o router_load -I../../.. *.cpp
//
// Use (the router command, if any, follows "--"; otherwise give --router-pid or neither):
//   router_load --direct                      no router: UDP->UDP sink and PTY master->slave
//   router_load --pump                        trivial in-house byte pump as router (floor)
//   router_load --relay                       two threads that block in read(2) (lower floor)
//   router_load --fc-link ./fc0 --sim-router-port 14560 -- ./casd --config x.toml
//
// Profiles (--profile):
//   hil    500 Hz HIL_SENSOR + 5 Hz HIL_GPS sim->fc, 400 Hz HIL_CONTROLS fc->sim (default)
//   rate   --down-hz X (HIL_SENSOR sim->fc) --up-hz Y (controls fc->sim)
//   flood  as fast as possible; --dir down|up|both; --window W keeps at most W frames in
//          flight per direction (closed loop: throughput without self-inflicted loss)
//   sweep  rising rates, --dir down|up, reports the highest one with loss <= 0.1 %
//
// Options: --seconds S (10)  --warmup S (0.5)  --drain-ms N (500)  --ctrl 91|93 (91)
//   --sim-local-port P  --sim-router-port P  --gcs N  --gcs-base-port P (15000)
//   --gcs-router-port P (all GCS talk to this one UDP server port of the router; without it
//   the router must send to the GCS ports)  --tcp M  --tcp-stall K  --tcp-port P (5760)
//   --fc-baud B (the fc reads like a B baud UART)  --hangup-at S --hangup-ms N (the PTY
//   vanishes and comes back under the same symlink: does the router recover, and when?)
//   --router-pid PID  --router-log FILE  --label TEXT  --json FILE ("-" = stdout, default)
//   --no-prime-check  --settle-ms N (0)  --rt (the bench's receive and paced send threads run
//   SCHED_FIFO: on a busy machine the tail is then the router's delay, not the bench's)
//
// Reading the figures: latency is user space to user space, from just before the sender's
// write to just after the receiver's read, so it contains the kernel's UDP/PTY path and the
// scheduling delay of the bench's own receive thread; compare with --direct and --pump on
// the same machine. "sent" counts frames offered (also while the PTY is away), "lost" those
// not seen within the drain time, "stale" frames of an earlier phase. A PTY is not a
// UART: it has no line rate and buffers some 4-70 KiB in the kernel.
// The bench keeps the PTY slave open as well (never reading it) so that raw mode is set
// before the router starts and a router restart does not hang up the master.
//
#include <fcntl.h>
#include <netinet/tcp.h>
#include <signal.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <thread>

#include "tests/bench/router_load/options.hpp"
#include "tests/bench/router_load/phase.hpp"
#include "tests/bench/router_load/receive.hpp"
#include "tests/bench/router_load/report.hpp"
#include "tests/bench/router_load/router.hpp"
#include "tests/bench/router_load/send.hpp"
#include "tests/bench/router_load/state.hpp"

using namespace router_load;

namespace {

// Rising rates, until the router or the bench cannot keep one.
std::string sweep(Phase ph) {
  const bool dn = o.dir != "up";
  const bool up = o.dir != "down";
  double best = 0;
  std::string steps;
  for (double hz : {1000., 2000., 5000., 10000., 15000., 20000., 30000., 40000., 50000., 65000.,
                    80000., 100000., 125000., 150000., 200000., 250000., 300000.}) {
    ph.down = dn ? hz : 0;
    ph.up = up ? hz : 0;
    ph.seconds = std::min(o.seconds, 3.0);
    Out r = run_phase(ph);
    double sent = 0, got = 0;
    for (int f : {int(SIM_SENSOR), int(FC_CTRL)}) {
      sent += double(r.sent[f]);
      auto& p = g_link[f == SIM_SENSOR ? L_FC : L_SIM]->path[f];
      if (p) got += double(p->delivered);
    }
    double want = ((dn ? hz : 0) + (up ? hz : 0)) * ph.seconds;
    bool kept = sent >= want * 0.98, ok = got >= sent * 0.999;
    fprintf(stderr, "-- %.0f Hz: sent %.0f%s delivered %.0f (%.3f %% lost)\n", hz, sent,
            kept ? "" : " (the bench or a full PTY could not keep this rate)", got,
            100 * (1 - got / std::max(1.0, sent)));
    steps += (steps.empty() ? "" : ",") + report(ph, r, true);
    if (ok && kept) best = hz;
    if (!kept || got < sent * 0.9) break;
  }
  const std::string body =
      "\"max_lossless_hz\":" + std::to_string(int(best)) + ",\"steps\":[" + steps + "]";
  fprintf(stderr, "highest rate with <= 0.1 %% loss: %.0f Hz (%s)\n", best, o.dir.c_str());
  return body;
}

void add_link(std::string n, int fd, bool stream) {
  g_link.push_back(std::make_unique<Link>());
  Link& l = *g_link.back();
  l.name = std::move(n);
  l.fd = fd;
  l.stream = stream;
}

// Opens the clients of --tcp and --tcp-stall. @return false when the router does not listen
bool connect_clients() {
  for (int i = 0; i < o.tcp + o.tcp_stall; ++i) {
    bool stall = i < o.tcp_stall;
    int fd = -1;
    for (int k = 0; k < 60; ++k) {
      fd = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
      int one = 1, small = 4096;
      setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &one, sizeof one);
      if (stall) setsockopt(fd, SOL_SOCKET, SO_RCVBUF, &small, sizeof small);
      sockaddr_in a = lo_addr(o.tcp_port);
      if (!connect(fd, reinterpret_cast<sockaddr*>(&a), sizeof a)) break;
      close(fd);
      fd = -1;
      sleep_ns(50000000);
    }
    if (fd < 0) {
      fprintf(stderr, "cannot connect to TCP port %d\n", o.tcp_port);
      return false;
    }
    fcntl(fd, F_SETFL, fcntl(fd, F_GETFL) | O_NONBLOCK);
    add_link((stall ? "stall" : "tcp") + std::to_string(stall ? i : i - o.tcp_stall), fd, true);
    g_link.back()->stalled = stall;
  }
  return true;
}

// Opens what stands at the ends: PTY, simulator's socket, UDP ground stations. @return the slave
std::string open_endpoints() {
  std::string slave;
  int master = open_pty(slave);
  relink(slave);
  g_fc_tx = master;
  g_sim_fd = udp_socket(o.sim_local);
  if (o.direct) {
    int sink = udp_socket(0);
    add_link("fc", sink, false);          // receives the simulator's packets
    add_link("sim", g_slave_keep, true);  // receives the controller's packets
    g_sim_dst = lo_addr(udp_port(sink));
    return slave;
  }
  if ((o.pump || o.relay) && !o.sim_router) o.sim_router = 14599;
  add_link("fc", master, true);
  add_link("sim", g_sim_fd, false);
  if (o.sim_router) g_sim_dst = lo_addr(o.sim_router);
  for (int i = 0; i < o.gcs; ++i)
    add_link("gcs" + std::to_string(i), udp_socket(o.gcs_base + i), false);
  return slave;
}

// Routes are learned from heartbeats. @return whether they pass both ways
bool prime() {
  bool primed = false;
  for (int i = 0; i < 100 && !primed; ++i) {
    send_flow(SIM_HB);
    send_flow(FC_HB);
    heartbeats_from_clients();
    sleep_ns(50000000);
    primed = i >= 4 && g_prim[SIM_HB] > 0 && g_prim[FC_HB] > 0;
  }
  if (primed || !o.prime_check) return true;
  fprintf(stderr, "no route: heartbeats sim->fc %llu, fc->sim %llu\n",
          (unsigned long long)g_prim[SIM_HB], (unsigned long long)g_prim[FC_HB]);
  return false;
}

// Plays the profile. @return its figures, as members of a JSON object
std::string run_profile() {
  if (!o.label.empty()) fprintf(stderr, "== %s, profile %s\n", o.label.c_str(), o.profile.c_str());
  Phase ph;
  ph.seconds = o.seconds;
  if (o.profile == "hil") {
    ph.down = 500;
    ph.up = 400;
    ph.gps = 5;
  } else if (o.profile == "rate") {
    ph.down = o.down_hz;
    ph.up = o.up_hz;
  } else if (o.profile == "flood") {
    ph.flood_down = o.dir != "up";
    ph.flood_up = o.dir != "down";
  } else if (o.profile == "sweep") {
    return sweep(ph);
  }
  Out r = run_phase(ph);
  return "\"result\":" + report(ph, r, true);
}

// The whole answer; `body` holds the measurements.
std::string answer(const std::string& body) {
  std::string cmd = o.direct ? "(direct)" : o.pump ? "(pump)" : o.relay ? "(relay)" : "";
  for (char* c : o.cmd)
    if (c) cmd += (cmd.empty() ? "" : " ") + std::string(c);
  double load[3] = {0, 0, 0};
  (void)!getloadavg(load, 3);
  std::string j = "{\"tool\":\"router_load\",\"label\":\"" + esc(o.label) + "\",\"profile\":\"" +
                  o.profile + "\",\"router_cmd\":\"" + esc(cmd) + "\",";
  app(j,
      "\"cpus\":%ld,\"loadavg1\":%.2f,\"bench_rt\":%s,\"gcs\":%d,\"tcp\":%d,\"tcp_stalled\":%d,"
      "\"fc_baud\":%d,",
      sysconf(_SC_NPROCESSORS_ONLN), load[0], o.rt ? "true" : "false", o.gcs, o.tcp, o.tcp_stall,
      o.fc_baud);
  return j + body + "}\n";
}

void write_out(const std::string& text) {
  if (o.json == "-")
    fputs(text.c_str(), stdout);
  else if (FILE* f = fopen(o.json.c_str(), "w")) {
    fputs(text.c_str(), f);
    fclose(f);
  }
}

}  // namespace

int main(int argc, char** argv) {
  signal(SIGPIPE, SIG_IGN);
  if (!parse_options(argc, argv)) return 2;
  const std::string slave = open_endpoints();
  start_router(slave);
  wait_for_router(slave);
  if (!connect_clients()) return 2;

  std::thread rx(rx_thread);
  const bool primed = prime();
  std::string body = primed ? run_profile() : "\"error\":\"no route\"";
  g_rxstop = true;
  rx.join();

  body += stop_router();
  if (!o.fc_link.empty()) unlink(o.fc_link.c_str());
  write_out(answer(body));
  return primed ? 0 : 3;
}
