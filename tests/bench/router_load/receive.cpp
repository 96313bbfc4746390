// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/router_load/receive.hpp"

#include <errno.h>
#include <pthread.h>
#include <sys/epoll.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/timerfd.h>
#include <unistd.h>

#include "tests/bench/router_load/parse.hpp"
#include "tests/bench/router_load/state.hpp"

namespace router_load {
namespace {

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

}  // namespace

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

}  // namespace router_load
