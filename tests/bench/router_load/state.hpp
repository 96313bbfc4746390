// SPDX-License-Identifier: BSD-3-Clause
// What the threads of the bench share. One program, one run: globals.
#pragma once

#include <netinet/in.h>
#include <sys/types.h>

#include <array>
#include <atomic>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "tests/bench/router_load/statistics.hpp"
#include "tests/bench/router_load/wire.hpp"

namespace router_load {

struct Opt {
  std::string profile = "hil", dir = "both", fc_link, router_log, label, json = "-";
  double seconds = 10, warmup = 0.5, hangup_at = -1;
  double down_hz = 500, up_hz = 400, gps_hz = 5;
  int drain_ms = 500, sim_local = 0, sim_router = 0, gcs = 0, gcs_base = 15000, gcs_router = 0;
  int tcp = 0, tcp_stall = 0, tcp_port = 5760, window = 0, fc_baud = 0, hangup_ms = 1000,
      settle_ms = 0;
  bool direct = false, pump = false, relay = false, prime_check = true, rt = false;
  pid_t pid = 0;
  std::vector<char*> cmd;
};
extern Opt o;

struct Link {
  std::string name;
  int fd = -1;
  bool stream = false, stalled = false;
  std::vector<uint8_t> buf;  // partial frame of a stream
  sockaddr_in peer{};        // learned from the last datagram
  bool has_peer = false;
  uint64_t frames = 0, bytes = 0, crc_bad = 0, garbage = 0, payload_bad = 0, other = 0,
           foreign_seq = 0;
  std::unique_ptr<PathStat> path[N_FLOW];
};

enum { L_FC = 0, L_SIM = 1 };
extern std::vector<std::unique_ptr<Link>> g_link;
extern std::mutex g_mu;                      // stats and g_link contents, held per batch
extern std::atomic<uint32_t> g_seq[N_FLOW];  // next sequence number of each flow
extern std::atomic<uint64_t> g_txfail, g_txlate;
extern std::array<std::atomic<uint64_t>, N_FLOW> g_prim;  // frames seen on the flow's primary path
extern uint32_t g_base[N_FLOW];  // first sequence number of the current phase
extern std::atomic<bool> g_measure, g_rxstop, g_txstop;
extern std::atomic<uint8_t> g_wire_sim, g_wire_fc;
extern std::mutex g_fc_mu;        // guards the PTY master against the swap
extern std::atomic<int> g_fc_tx;  // PTY master
extern int g_slave_keep, g_sim_fd;
extern sockaddr_in g_sim_dst;
extern std::atomic<bool> g_sim_dst_ok;
extern std::atomic<int> g_swap;  // 1: drop the PTY, 2: bring it back
extern std::atomic<int64_t> g_back_at, g_rec_down, g_rec_up;
// Frames that reached the fc after the PTY came back: how many were sent before, the oldest age.
extern std::atomic<int64_t> g_back_stale, g_back_oldest;
extern pid_t g_child;

int64_t now_ns();
void sleep_until(int64_t ns);
void sleep_ns(int64_t d);
[[noreturn]] void die(const char* what);

sockaddr_in lo_addr(int port);
int udp_socket(int port);
int udp_port(int fd);
/// A raw PTY; the slave stays open here. @return the master
int open_pty(std::string& slave_name);
/// Puts --fc-link at the slave.
void relink(const std::string& slave);
/// SCHED_FIFO for this thread, with --rt.
void go_rt();

}  // namespace router_load
