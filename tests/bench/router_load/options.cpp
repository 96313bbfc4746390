// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/router_load/options.hpp"

#include <cstdio>
#include <cstdlib>
#include <string>

#include "tests/bench/router_load/state.hpp"

namespace router_load {

bool parse_options(int argc, char** argv) {
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
    else if (a == "--relay")
      o.relay = true;
    else if (a == "--rt")
      o.rt = true;
    else if (a == "--no-prime-check")
      o.prime_check = false;
    else {
      fprintf(stderr, "unknown option %s (see the head of main.cpp)\n", a.c_str());
      return false;
    }
  }
  return true;
}

}  // namespace router_load
