// SPDX-License-Identifier: BSD-3-Clause
#include <memory>

#include "casd/casctl/monitor/monitor_screen.hpp"
#include "casd/casctl/verbs/verbs.hpp"

namespace cas::casctl {

void add_monitor_verb(CommandLine& line) {
  struct Wish {
    bool once = false;
    double interval_s = 0.5;
  };
  const auto wish = std::make_shared<Wish>();
  CLI::App* verb = line.add_verb(
      "monitor", "Watch links, messages, values and gains on a full screen; command from it",
      "casctl monitor   or   casctl monitor --once", [wish](Session& session) {
        if (wish->once) return print_monitor(session);
        return run_monitor(session.options(), wish->interval_s);
      });
  verb->add_flag("--once", wish->once, "Print the messages as a plain table and end");
  verb->add_option("--interval", wish->interval_s, "Seconds between two looks")
      ->check(CLI::Range(0.1, 60.0))
      ->capture_default_str();
}

}  // namespace cas::casctl
