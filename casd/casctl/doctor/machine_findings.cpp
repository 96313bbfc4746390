// SPDX-License-Identifier: BSD-3-Clause
#include "casd/casctl/doctor/findings.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>

#include "casd/casctl/session/text.hpp"

namespace cas::casctl {
namespace {

using nlohmann::json;

constexpr double kClockStep_s = 0.005;
constexpr double kLateWake_us = 1000;

}  // namespace

void check_devices(const DoctorFacts& facts, Findings& all) {
  for (const DeviceFacts& device : facts.devices) {
    if (!device.exists) {
      bad(all, device.path + " does not exist",
          "plug the board in; /dev/serial/by-id shows names that last");
    } else if (!device.usable) {
      bad(all, device.path + " may not be opened by you",
          "sudo usermod -aG " + (device.group.empty() ? "dialout" : device.group) +
              " $USER, then log in again (casd needs the right, casctl does not)");
    } else if (device.latency_timer.value_or(1) > 1) {
      warn(all,
           fmt::format("{} holds packets back for up to {} ms", device.path, *device.latency_timer),
           "install config/udev/61-cas-pixhawk.rules, or echo 1 > "
           "/sys/bus/usb-serial/devices/TTY/latency_timer");
    } else {
      good(all, device.path + " is there and may be opened");
    }
  }
}

void check_machine(const DoctorFacts& facts, Findings& all) {
  const auto slow = std::find_if(facts.governors.begin(), facts.governors.end(),
                                 [](const std::string& name) { return name == "powersave"; });
  if (slow != facts.governors.end()) {
    warn(all, "the processors run in powersave mode",
         "sudo cpupower frequency-set -g performance while you fly");
  } else {
    good(all, facts.governors.empty() ? "no CPU frequency scaling"
                                      : "CPU frequency governor " + facts.governors.front());
  }
  if (std::abs(facts.clock_step_s) > kClockStep_s) {
    warn(all, "the wall clock moved by " + fixed(facts.clock_step_s * 1000, 1) + " ms",
         "let NTP settle before you fly: logs get wrong times (casd itself uses the steady clock)");
  } else {
    good(all, "the wall clock runs evenly");
  }
  const std::string wake = "a thread that sleeps 1 ms wakes up to " + fixed(facts.wake_max_us, 0) +
                           " us late (99 %: " + fixed(facts.wake_p99_us, 0) + " us)";
  if (facts.wake_p99_us > kLateWake_us) {
    warn(all, wake,
         "end other programs, or give casd real-time rights (config/systemd/casd-realtime.conf, "
         "scheduling in the topology)");
  } else {
    good(all, wake);
  }
}

}  // namespace cas::casctl
