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
// Build:  g++ -std=c++17 -O2 -pthread -o router_load router_load.cpp
//
// Use (the router command, if any, follows "--"; otherwise give --router-pid or neither):
//   router_load --direct                      no router: UDP->UDP sink and PTY master->slave
//   router_load --pump                        trivial in-house byte pump as router (floor)
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
// Plain POSIX/Linux, no dependency, loopback traffic only.

#include <arpa/inet.h>
#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <pthread.h>
#include <signal.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/timerfd.h>
#include <sys/types.h>
#include <sys/wait.h>
#include <termios.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace {

// ---------------------------------------------------------------- small helpers
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

// ---------------------------------------------------------------- MAVLink
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

enum Flow { SIM_SENSOR, SIM_GPS, SIM_HB, FC_CTRL, FC_HB, N_FLOW };
struct FlowDef {
  const char* name;
  uint32_t msgid;
  uint8_t sysid, compid;
  bool from_sim;
};
FlowDef g_flow[N_FLOW] = {
    {"sim.HIL_SENSOR", 107, 51, 1, true}, {"sim.HIL_GPS", 113, 51, 1, true},
    {"sim.HEARTBEAT", 0, 51, 1, true},    {"fc.HIL_CONTROLS", 91, 1, 1, false},
    {"fc.HEARTBEAT", 0, 1, 1, false},
};

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

// Fills an untruncated payload, returns its length.
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

// ---------------------------------------------------------------- statistics
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

// ---------------------------------------------------------------- global state
struct Opt {
  std::string profile = "hil", dir = "both", fc_link, router_log, label, json = "-";
  double seconds = 10, warmup = 0.5, hangup_at = -1;
  double down_hz = 500, up_hz = 400, gps_hz = 5;
  int drain_ms = 500, sim_local = 0, sim_router = 0, gcs = 0, gcs_base = 15000, gcs_router = 0;
  int tcp = 0, tcp_stall = 0, tcp_port = 5760, window = 0, fc_baud = 0, hangup_ms = 1000,
      settle_ms = 0;
  bool direct = false, pump = false, prime_check = true, rt = false;
  pid_t pid = 0;
  std::vector<char*> cmd;
} o;

enum { L_FC = 0, L_SIM = 1 };
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
pid_t g_child = 0;

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

// ---------------------------------------------------------------- receiving
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

// Parses what it can, returns the number of bytes consumed.
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

void rx_stream(Link& l, size_t li, size_t max_bytes, bool& eof) {
  static uint8_t tmp[65536];
  ssize_t r = read(l.fd, tmp, std::min(sizeof tmp, max_bytes));
  if (r <= 0) {
    eof = r == 0 || (errno != EAGAIN && errno != EINTR);
    return;
  }
  int64_t t = now_ns();
  l.bytes += uint64_t(r);
  if (l.buf.empty()) {
    size_t used = parse(l, li, tmp, size_t(r), t, false);
    l.buf.assign(tmp + used, tmp + r);
  } else {
    l.buf.insert(l.buf.end(), tmp, tmp + r);
    size_t used = parse(l, li, l.buf.data(), l.buf.size(), t, false);
    l.buf.erase(l.buf.begin(), l.buf.begin() + long(used));
  }
}
void rx_udp(Link& l, size_t li) {
  constexpr int B = 32;
  static uint8_t data[B][2048];
  static mmsghdr mm[B];
  static iovec iv[B];
  static sockaddr_in from[B];
  for (int i = 0; i < B; ++i) {
    iv[i] = {data[i], sizeof data[i]};
    mm[i] = {};
    mm[i].msg_hdr.msg_iov = &iv[i];
    mm[i].msg_hdr.msg_iovlen = 1;
    mm[i].msg_hdr.msg_name = &from[i];
    mm[i].msg_hdr.msg_namelen = sizeof from[i];
  }
  int r = recvmmsg(l.fd, mm, B, MSG_DONTWAIT, nullptr);
  int64_t t = now_ns();
  for (int i = 0; i < r; ++i) {
    l.bytes += mm[i].msg_len;
    l.peer = from[i];
    l.has_peer = true;
    parse(l, li, data[i], mm[i].msg_len, t, true);
  }
  if (r > 0 && li == L_SIM && !o.sim_router && !g_sim_dst_ok) {
    g_sim_dst = l.peer;
    g_sim_dst_ok = true;
  }
}

void rx_thread() {
  prctl(PR_SET_TIMERSLACK, 1);
  pthread_setname_np(pthread_self(), "rl-rx");
  go_rt();
  int ep = epoll_create1(EPOLL_CLOEXEC);
  auto add = [&](int fd, uint64_t tag) {
    epoll_event e{};
    e.events = EPOLLIN;
    e.data.u64 = tag;
    epoll_ctl(ep, EPOLL_CTL_ADD, fd, &e);
  };
  constexpr uint64_t TICK = 1u << 20;
  int tfd = -1;
  double credit = 0;
  for (size_t i = 0; i < g_link.size(); ++i)
    if (!g_link[i]->stalled && !(i == L_FC && o.fc_baud)) add(g_link[i]->fd, i);
  if (o.fc_baud) {
    tfd = timerfd_create(CLOCK_MONOTONIC, TFD_NONBLOCK | TFD_CLOEXEC);
    itimerspec it{{0, 1000000}, {0, 1000000}};
    timerfd_settime(tfd, 0, &it, nullptr);
    add(tfd, TICK);
  }
  epoll_event ev[64];
  while (!g_rxstop) {
    if (int s = g_swap.exchange(0)) {
      std::lock_guard<std::mutex> a(g_fc_mu), b(g_mu);
      if (s == 1) {
        if (!o.fc_baud) epoll_ctl(ep, EPOLL_CTL_DEL, g_fc_tx, nullptr);
        close(g_slave_keep);
        close(g_fc_tx);
        g_fc_tx = -1;
        g_link[L_FC]->fd = -1;
        g_link[L_FC]->buf.clear();
        if (!o.fc_link.empty()) unlink(o.fc_link.c_str());
      } else {
        std::string sn;
        int m = open_pty(sn);
        g_link[L_FC]->fd = m;
        if (!o.fc_baud) add(m, L_FC);
        g_fc_tx = m;
        g_back_at = now_ns();
        relink(sn);
      }
    }
    int n = epoll_wait(ep, ev, 64, 50);
    if (n <= 0) continue;
    std::lock_guard<std::mutex> k(g_mu);
    for (int i = 0; i < n; ++i) {
      bool eof = false;
      if (ev[i].data.u64 == TICK) {
        uint64_t x;
        if (read(tfd, &x, sizeof x) != sizeof x) continue;
        credit = std::min(credit + double(x) * o.fc_baud / 10000.0, o.fc_baud / 10000.0 * 4);
        if (credit >= 1 && g_link[L_FC]->fd >= 0) {
          uint64_t before = g_link[L_FC]->bytes;
          rx_stream(*g_link[L_FC], L_FC, size_t(credit), eof);
          credit -= double(g_link[L_FC]->bytes - before);
        }
        continue;
      }
      size_t li = size_t(ev[i].data.u64);
      Link& l = *g_link[li];
      if (l.fd < 0) continue;
      if (l.stream)
        rx_stream(l, li, 65536, eof);
      else
        rx_udp(l, li);
      if (eof && li != L_FC) {
        epoll_ctl(ep, EPOLL_CTL_DEL, l.fd, nullptr);
        l.has_peer = false;
      }
    }
  }
  close(ep);
  if (tfd >= 0) close(tfd);
}

// ---------------------------------------------------------------- sending
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

struct Item {
  Flow f;
  double hz;
  int64_t due;
};
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

// ---------------------------------------------------------------- router's resources
struct Res {
  double user = 0, sys = 0, run_ns = 0;
  uint64_t vcs = 0, ics = 0;
  long rss_kb = 0, hwm_kb = 0;
  int threads = 0;
  bool ok = false;
};
Res sample(pid_t pid) {
  Res r;
  if (pid <= 0) return r;
  char path[96], line[1024];
  snprintf(path, sizeof path, "/proc/%d/stat", pid);
  if (FILE* f = fopen(path, "r")) {
    if (fgets(line, sizeof line, f)) {
      char* p = strrchr(line, ')');
      unsigned long ut = 0, st = 0;
      if (p &&
          sscanf(p + 2, "%*c %*d %*d %*d %*d %*d %*u %*u %*u %*u %*u %lu %lu", &ut, &st) == 2) {
        double hz = double(sysconf(_SC_CLK_TCK));
        r.user = double(ut) / hz;
        r.sys = double(st) / hz;
        r.ok = true;
      }
    }
    fclose(f);
  }
  snprintf(path, sizeof path, "/proc/%d/status", pid);
  if (FILE* f = fopen(path, "r")) {
    while (fgets(line, sizeof line, f)) {
      sscanf(line, "VmRSS: %ld", &r.rss_kb);
      sscanf(line, "VmHWM: %ld", &r.hwm_kb);
    }
    fclose(f);
  }
  snprintf(path, sizeof path, "/proc/%d/task", pid);
  if (DIR* d = opendir(path)) {
    while (dirent* e = readdir(d)) {
      if (e->d_name[0] == '.') continue;
      ++r.threads;
      std::string b = std::string(path) + "/" + e->d_name;
      if (FILE* f = fopen((b + "/schedstat").c_str(), "r")) {
        unsigned long long ns = 0;
        if (fscanf(f, "%llu", &ns) == 1) r.run_ns += double(ns);
        fclose(f);
      }
      if (FILE* f = fopen((b + "/status").c_str(), "r")) {
        unsigned long v;
        while (fgets(line, sizeof line, f)) {
          if (sscanf(line, "voluntary_ctxt_switches: %lu", &v) == 1) r.vcs += v;
          if (sscanf(line, "nonvoluntary_ctxt_switches: %lu", &v) == 1) r.ics += v;
        }
        fclose(f);
      }
    }
    closedir(d);
  }
  return r;
}
long udp_drops(int port) {  // kernel receive-buffer drops of the router's UDP port
  if (!port) return -1;
  long total = -1;
  for (const char* fn : {"/proc/net/udp", "/proc/net/udp6"})
    if (FILE* f = fopen(fn, "r")) {
      char line[512];
      while (fgets(line, sizeof line, f)) {
        char local[80];
        if (sscanf(line, " %*d: %79s", local) != 1) continue;
        char* c = strchr(local, ':');
        if (!c || strtol(c + 1, nullptr, 16) != port) continue;
        char* last = strrchr(line, ' ');
        char* p = line + strlen(line) - 1;
        while (p > line && (*p == '\n' || *p == ' ')) *p-- = 0;
        last = strrchr(line, ' ');
        if (last) total = std::max(total, 0L) + atol(last + 1);
      }
      fclose(f);
    }
  return total;
}
bool has_slave_open(pid_t pid, const std::string& slave) {
  std::string d = "/proc/" + std::to_string(pid) + "/fd";
  DIR* dd = opendir(d.c_str());
  if (!dd) return false;
  bool yes = false;
  while (dirent* e = readdir(dd)) {
    char b[256];
    ssize_t n = readlink((d + "/" + e->d_name).c_str(), b, sizeof b - 1);
    if (n > 0) {
      b[n] = 0;
      if (slave == b) yes = true;
    }
  }
  closedir(dd);
  return yes;
}
bool alive(pid_t pid) {
  if (pid <= 0) return true;
  if (pid == g_child) {
    siginfo_t si{};
    if (waitid(P_PID, id_t(pid), &si, WEXITED | WNOHANG | WNOWAIT) == 0 && si.si_pid == pid)
      return false;
  }
  return kill(pid, 0) == 0;
}

// ---------------------------------------------------------------- trivial reference router
// One thread, poll(2), one datagram or read per turn, no framing at all.
[[noreturn]] void pump_main(const std::string& slave, int port) {
  int p = open(slave.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK), u = udp_socket(port);
  std::vector<sockaddr_in> gcs;
  for (int i = 0; i < o.gcs; ++i) gcs.push_back(lo_addr(o.gcs_base + i));
  sockaddr_in sim{};
  bool have = false;
  uint8_t b[65536];
  pollfd f[2] = {{p, POLLIN, 0}, {u, POLLIN, 0}};
  for (;;) {
    if (poll(f, 2, -1) < 0) continue;
    if (f[1].revents & POLLIN) {
      socklen_t sl = sizeof sim;
      sockaddr_in from{};
      ssize_t n = recvfrom(u, b, sizeof b, MSG_DONTWAIT, reinterpret_cast<sockaddr*>(&from), &sl);
      int sp = ntohs(from.sin_port);
      if (n > 0 && (sp < o.gcs_base || sp >= o.gcs_base + o.gcs)) {
        sim = from;
        have = true;
        for (ssize_t w = 0; w < n;) {
          ssize_t r = write(p, b + w, size_t(n - w));
          if (r > 0)
            w += r;
          else {
            pollfd q{p, POLLOUT, 0};
            poll(&q, 1, 10);
          }
        }
        for (auto& g : gcs) sendto(u, b, size_t(n), 0, reinterpret_cast<sockaddr*>(&g), sizeof g);
      }
    }
    if (f[0].revents & POLLIN) {
      ssize_t n = read(p, b, 1400);
      // Cut at frame starts would need framing; a datagram may carry a partial frame, so
      // the pump only walks complete MAVLink 2 lengths and keeps the remainder.
      static std::vector<uint8_t> keep;
      if (n > 0) {
        keep.insert(keep.end(), b, b + n);
        size_t i = 0;
        while (keep.size() - i >= 12) {
          if (keep[i] != 0xFD) {
            ++i;
            continue;
          }
          size_t t = size_t(keep[i + 1]) + 12;
          if (keep.size() - i < t) break;
          if (have) sendto(u, &keep[i], t, 0, reinterpret_cast<sockaddr*>(&sim), sizeof sim);
          for (auto& g : gcs) sendto(u, &keep[i], t, 0, reinterpret_cast<sockaddr*>(&g), sizeof g);
          i += t;
        }
        keep.erase(keep.begin(), keep.begin() + long(i));
      }
    }
  }
}

// ---------------------------------------------------------------- phases and report
struct Phase {
  double down = 0, up = 0, gps = 0, seconds = 0;
  bool flood_down = false, flood_up = false;
};

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

struct Out {
  Res a, b;
  double wall = 0;
  long drops0 = -1, drops1 = -1;
  uint64_t sent[N_FLOW] = {};
  bool alive = true;
};

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

void app(std::string& s, const char* fmt, ...) __attribute__((format(printf, 2, 3)));
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
        "up_ms\":%.1f}",
        d ? "true" : "false", u ? "true" : "false", d ? double(d - b) / 1e6 : -1,
        u ? double(u - b) / 1e6 : -1);
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

}  // namespace

int main(int argc, char** argv) {
  signal(SIGPIPE, SIG_IGN);
  for (int i = 1; i < argc; ++i) {
    std::string a = argv[i];
    auto val = [&]() -> const char* {
      if (i + 1 >= argc) {
        fprintf(stderr, "%s needs a value\n", a.c_str());
        exit(2);
      }
      return argv[++i];
    };
    if (a == "--") {
      for (++i; i < argc; ++i) o.cmd.push_back(argv[i]);
      break;
    } else if (a == "--profile")
      o.profile = val();
    else if (a == "--dir")
      o.dir = val();
    else if (a == "--seconds")
      o.seconds = atof(val());
    else if (a == "--warmup")
      o.warmup = atof(val());
    else if (a == "--drain-ms")
      o.drain_ms = atoi(val());
    else if (a == "--down-hz")
      o.down_hz = atof(val());
    else if (a == "--up-hz")
      o.up_hz = atof(val());
    else if (a == "--window")
      o.window = atoi(val());
    else if (a == "--ctrl") {
      if (atoi(val()) == 93) {
        g_flow[FC_CTRL].msgid = 93;
        g_flow[FC_CTRL].name = "fc.HIL_ACT_CTRL";
      }
    } else if (a == "--fc-link")
      o.fc_link = val();
    else if (a == "--fc-baud")
      o.fc_baud = atoi(val());
    else if (a == "--hangup-at")
      o.hangup_at = atof(val());
    else if (a == "--hangup-ms")
      o.hangup_ms = atoi(val());
    else if (a == "--sim-local-port")
      o.sim_local = atoi(val());
    else if (a == "--sim-router-port")
      o.sim_router = atoi(val());
    else if (a == "--gcs")
      o.gcs = atoi(val());
    else if (a == "--gcs-base-port")
      o.gcs_base = atoi(val());
    else if (a == "--gcs-router-port")
      o.gcs_router = atoi(val());
    else if (a == "--tcp")
      o.tcp = atoi(val());
    else if (a == "--tcp-stall")
      o.tcp_stall = atoi(val());
    else if (a == "--tcp-port")
      o.tcp_port = atoi(val());
    else if (a == "--router-pid")
      o.pid = atoi(val());
    else if (a == "--router-log")
      o.router_log = val();
    else if (a == "--label")
      o.label = val();
    else if (a == "--json")
      o.json = val();
    else if (a == "--settle-ms")
      o.settle_ms = atoi(val());
    else if (a == "--direct")
      o.direct = true;
    else if (a == "--pump")
      o.pump = true;
    else if (a == "--rt")
      o.rt = true;
    else if (a == "--no-prime-check")
      o.prime_check = false;
    else {
      fprintf(stderr, "unknown option %s (see the head of router_load.cpp)\n", a.c_str());
      return 2;
    }
  }
  // endpoints
  std::string slave;
  int master = open_pty(slave);
  relink(slave);
  g_fc_tx = master;
  g_sim_fd = udp_socket(o.sim_local);
  auto add_link = [&](std::string n, int fd, bool stream) {
    g_link.push_back(std::make_unique<Link>());
    Link& l = *g_link.back();
    l.name = std::move(n);
    l.fd = fd;
    l.stream = stream;
  };
  if (o.direct) {
    int sink = udp_socket(0);
    add_link("fc", sink, false);          // receives what the simulator sends
    add_link("sim", g_slave_keep, true);  // receives what the flight controller sends
    g_sim_dst = lo_addr(udp_port(sink));
  } else {
    if (o.pump && !o.sim_router) o.sim_router = 14599;
    add_link("fc", master, true);
    add_link("sim", g_sim_fd, false);
    if (o.sim_router) g_sim_dst = lo_addr(o.sim_router);
    for (int i = 0; i < o.gcs; ++i)
      add_link("gcs" + std::to_string(i), udp_socket(o.gcs_base + i), false);
  }
  // the router
  if (o.pump || !o.cmd.empty()) {
    g_child = fork();
    if (g_child == 0) {
      prctl(PR_SET_PDEATHSIG, SIGTERM);
      if (o.pump) {
        prctl(PR_SET_TIMERSLACK, 1);
        pump_main(slave, o.sim_router);
      }
      int lf = open(o.router_log.empty() ? "/dev/null" : o.router_log.c_str(),
                    O_WRONLY | O_CREAT | O_TRUNC, 0644);
      int nul = open("/dev/null", O_RDONLY);
      dup2(nul, 0);
      dup2(lf, 1);
      dup2(lf, 2);
      o.cmd.push_back(nullptr);
      execvp(o.cmd[0], o.cmd.data());
      _exit(127);
    }
    o.pid = g_child;
  }
  if (o.pid > 0) {
    int64_t t = now_ns();
    while (!has_slave_open(o.pid, slave) && now_ns() - t < 5000000000LL && alive(o.pid))
      sleep_ns(10000000);
    if (!has_slave_open(o.pid, slave))
      fprintf(stderr, "warning: the router has not opened the PTY slave %s\n", slave.c_str());
  } else if (!o.direct && !o.settle_ms)
    o.settle_ms = 1000;
  sleep_ns(int64_t(o.settle_ms) * 1000000);
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
      return 2;
    }
    fcntl(fd, F_SETFL, fcntl(fd, F_GETFL) | O_NONBLOCK);
    add_link((stall ? "stall" : "tcp") + std::to_string(stall ? i : i - o.tcp_stall), fd, true);
    g_link.back()->stalled = stall;
  }
  std::thread rx(rx_thread);
  // prime: routes are learned from heartbeats
  bool primed = false;
  for (int i = 0; i < 100 && !primed; ++i) {
    send_flow(SIM_HB);
    send_flow(FC_HB);
    heartbeats_from_clients();
    sleep_ns(50000000);
    primed = i >= 4 && g_prim[SIM_HB] > 0 && g_prim[FC_HB] > 0;
  }
  int rc = 0;
  std::string body;
  if (!primed && o.prime_check) {
    fprintf(stderr, "no route: heartbeats sim->fc %llu, fc->sim %llu\n",
            (unsigned long long)g_prim[SIM_HB], (unsigned long long)g_prim[FC_HB]);
    rc = 3;
    body = "\"error\":\"no route\"";
  } else {
    if (!o.label.empty())
      fprintf(stderr, "== %s, profile %s\n", o.label.c_str(), o.profile.c_str());
    Phase ph;
    ph.seconds = o.seconds;
    bool dn = o.dir != "up", up = o.dir != "down";
    if (o.profile == "hil") {
      ph.down = 500;
      ph.up = 400;
      ph.gps = 5;
    } else if (o.profile == "rate") {
      ph.down = o.down_hz;
      ph.up = o.up_hz;
    } else if (o.profile == "flood") {
      ph.flood_down = dn;
      ph.flood_up = up;
    }
    if (o.profile == "sweep") {
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
      body = "\"max_lossless_hz\":" + std::to_string(int(best)) + ",\"steps\":[" + steps + "]";
      fprintf(stderr, "highest rate with <= 0.1 %% loss: %.0f Hz (%s)\n", best, o.dir.c_str());
    } else {
      Out r = run_phase(ph);
      body = "\"result\":" + report(ph, r, true);
    }
  }
  g_rxstop = true;
  rx.join();
  if (g_child > 0) {
    kill(g_child, SIGTERM);
    int st = 0;
    rusage ru{};
    pid_t w = 0;
    for (int i = 0; i < 200 && w == 0; ++i) {
      w = wait4(g_child, &st, WNOHANG, &ru);
      if (!w) sleep_ns(10000000);
    }
    if (w == 0) {
      kill(g_child, SIGKILL);
      wait4(g_child, &st, 0, &ru);
    }
    app(body, ",\"rusage\":{\"user_s\":%.3f,\"sys_s\":%.3f,\"maxrss_kb\":%ld,\"clean_exit\":%s}",
        double(ru.ru_utime.tv_sec) + double(ru.ru_utime.tv_usec) / 1e6,
        double(ru.ru_stime.tv_sec) + double(ru.ru_stime.tv_usec) / 1e6, ru.ru_maxrss,
        w != 0 && (WIFEXITED(st) || WTERMSIG(st) == SIGTERM) ? "true" : "false");
  }
  if (!o.fc_link.empty()) unlink(o.fc_link.c_str());
  std::string cmd = o.direct ? "(direct)" : o.pump ? "(pump)" : "";
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
  j += body + "}\n";
  if (o.json == "-")
    fputs(j.c_str(), stdout);
  else if (FILE* f = fopen(o.json.c_str(), "w")) {
    fputs(j.c_str(), f);
    fclose(f);
  }
  return rc;
}
