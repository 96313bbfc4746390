// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/router_load/state.hpp"

#include <arpa/inet.h>
#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <sys/socket.h>
#include <termios.h>
#include <time.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace router_load {

Opt o;
std::vector<std::unique_ptr<Link>> g_link;
std::mutex g_mu;                      // stats and g_link contents, held per batch
std::atomic<uint32_t> g_seq[N_FLOW];  // next sequence number of each flow
std::atomic<uint64_t> g_txfail{0}, g_txlate{0};
std::array<std::atomic<uint64_t>, N_FLOW> g_prim;  // frames seen on the flow's primary path
uint32_t g_base[N_FLOW];                           // first sequence number of the current phase
std::atomic<bool> g_measure{false}, g_rxstop{false}, g_txstop{false};
std::atomic<uint8_t> g_wire_sim{0}, g_wire_fc{0};
std::mutex g_fc_mu;            // guards the PTY master against the swap
std::atomic<int> g_fc_tx{-1};  // PTY master
int g_slave_keep = -1, g_sim_fd = -1;
sockaddr_in g_sim_dst{};
std::atomic<bool> g_sim_dst_ok{false};
std::atomic<int> g_swap{0};  // 1: drop the PTY, 2: bring it back
std::atomic<int64_t> g_back_at{0}, g_rec_down{0}, g_rec_up{0};
std::atomic<int64_t> g_back_stale{0}, g_back_oldest{0};
pid_t g_child = 0;

int64_t now_ns() {
  timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return int64_t(t.tv_sec) * 1000000000 + t.tv_nsec;
}
void sleep_until(int64_t ns) {
  timespec t{time_t(ns / 1000000000), long(ns % 1000000000)};
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &t, nullptr) == EINTR) {
  }
}
void sleep_ns(int64_t d) { sleep_until(now_ns() + d); }
[[noreturn]] void die(const char* what) {
  fprintf(stderr, "router_load: %s: %s\n", what, strerror(errno));
  exit(2);
}

sockaddr_in lo_addr(int port) {
  sockaddr_in a{};
  a.sin_family = AF_INET;
  a.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  a.sin_port = htons(uint16_t(port));
  return a;
}
int udp_socket(int port) {
  int fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (fd < 0) die("socket");
  int big = 8 << 20;
  if (setsockopt(fd, SOL_SOCKET, SO_RCVBUFFORCE, &big, sizeof big))
    setsockopt(fd, SOL_SOCKET, SO_RCVBUF, &big, sizeof big);
  sockaddr_in a = lo_addr(port);
  if (bind(fd, reinterpret_cast<sockaddr*>(&a), sizeof a)) die("bind udp");
  return fd;
}
int udp_port(int fd) {
  sockaddr_in a{};
  socklen_t n = sizeof a;
  getsockname(fd, reinterpret_cast<sockaddr*>(&a), &n);
  return ntohs(a.sin_port);
}
int open_pty(std::string& slave_name) {
  int m = posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC | O_NONBLOCK);
  if (m < 0 || grantpt(m) || unlockpt(m)) die("pty");
  slave_name = ptsname(m);
  int s = open(slave_name.c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC | O_NONBLOCK);
  if (s < 0) die("pty slave");
  termios t;
  tcgetattr(s, &t);
  cfmakeraw(&t);
  cfsetspeed(&t, B921600);
  tcsetattr(s, TCSANOW, &t);
  g_slave_keep = s;
  return m;
}
void relink(const std::string& slave) {
  if (o.fc_link.empty()) return;
  std::string tmp = o.fc_link + ".new";
  unlink(tmp.c_str());
  if (symlink(slave.c_str(), tmp.c_str()) || rename(tmp.c_str(), o.fc_link.c_str())) die("symlink");
}

void go_rt() {
  if (!o.rt) return;
  sched_param sp{};
  sp.sched_priority = 50;
  if (pthread_setschedparam(pthread_self(), SCHED_FIFO, &sp))
    fprintf(stderr, "warning: --rt refused\n");
}

}  // namespace router_load
