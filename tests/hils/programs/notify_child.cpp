// SPDX-License-Identifier: BSD-3-Clause
// Stand-in for a program of a run: says that it is ready, then acts by its argument.
//   notify_child wait    ends with 0 on SIGTERM
//   notify_child deaf    ignores SIGTERM
//   notify_child crash   kills itself
#include <signal.h>
#include <unistd.h>

#include <string_view>

#include "base/os/notify.hpp"

int main(int argc, char** argv) {
  const std::string_view mode = argc > 1 ? argv[1] : "";
  sigset_t term;
  ::sigemptyset(&term);
  ::sigaddset(&term, SIGTERM);
  ::sigprocmask(SIG_BLOCK, &term, nullptr);
  cas::base::notify("READY=1\nSTATUS=ready");
  if (mode == "crash") ::raise(SIGKILL);
  int signal = 0;
  do {
    ::sigwait(&term, &signal);
  } while (mode == "deaf");
  return 0;
}
