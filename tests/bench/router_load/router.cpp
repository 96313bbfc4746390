// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/router_load/router.hpp"

#include <fcntl.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>

#include "tests/bench/router_load/process.hpp"
#include "tests/bench/router_load/pump.hpp"
#include "tests/bench/router_load/report.hpp"
#include "tests/bench/router_load/state.hpp"

namespace router_load {
namespace {

// The child's side of start_router().
[[noreturn]] void become_router(const std::string& slave) {
  prctl(PR_SET_PDEATHSIG, SIGTERM);
  if (o.pump) {
    prctl(PR_SET_TIMERSLACK, 1);
    pump_main(slave, o.sim_router);
  }
  if (o.relay) relay_main(slave, o.sim_router);
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

}  // namespace

void start_router(const std::string& slave) {
  if (!o.pump && !o.relay && o.cmd.empty()) return;
  g_child = fork();
  if (g_child == 0) become_router(slave);
  o.pid = g_child;
}

void wait_for_router(const std::string& slave) {
  if (o.pid > 0) {
    int64_t t = now_ns();
    while (!has_slave_open(o.pid, slave) && now_ns() - t < 5000000000LL && alive(o.pid))
      sleep_ns(10000000);
    if (!has_slave_open(o.pid, slave))
      fprintf(stderr, "warning: the router has not opened the PTY slave %s\n", slave.c_str());
  } else if (!o.direct && !o.settle_ms) {
    o.settle_ms = 1000;
  }
  sleep_ns(int64_t(o.settle_ms) * 1000000);
}

std::string stop_router() {
  if (g_child <= 0) return "";
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
  std::string used;
  app(used, ",\"rusage\":{\"user_s\":%.3f,\"sys_s\":%.3f,\"maxrss_kb\":%ld,\"clean_exit\":%s}",
      double(ru.ru_utime.tv_sec) + double(ru.ru_utime.tv_usec) / 1e6,
      double(ru.ru_stime.tv_sec) + double(ru.ru_stime.tv_usec) / 1e6, ru.ru_maxrss,
      w != 0 && (WIFEXITED(st) || WTERMSIG(st) == SIGTERM) ? "true" : "false");
  return used;
}

}  // namespace router_load
