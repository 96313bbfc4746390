// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/router_load/process.hpp"

#include <dirent.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "tests/bench/router_load/state.hpp"

namespace router_load {

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
long udp_drops(int port) {
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

}  // namespace router_load
