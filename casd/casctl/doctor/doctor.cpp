// SPDX-License-Identifier: BSD-3-Clause
#include "casd/casctl/doctor/doctor.hpp"

#include <grp.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <memory>
#include <set>
#include <string>

#include "base/enum_words.hpp"
#include "casd/casctl/doctor/findings.hpp"

namespace cas::casctl {
namespace {

using nlohmann::json;

double clock_s(clockid_t clock) {
  timespec time{};
  ::clock_gettime(clock, &time);
  return static_cast<double>(time.tv_sec) + static_cast<double>(time.tv_nsec) * 1e-9;
}

/// How far the wall clock is ahead of the monotonic one.
double wall_offset_s() { return clock_s(CLOCK_REALTIME) - clock_s(CLOCK_MONOTONIC); }

/// Lateness in microseconds of a thread that asks to be woken every millisecond.
std::vector<double> measure_wake_ups(double seconds) {
  constexpr long kPeriod_ns = 1'000'000;
  std::vector<double> late_us;
  timespec next{};
  ::clock_gettime(CLOCK_MONOTONIC, &next);
  const auto count = static_cast<int>(seconds * 1000);
  for (int i = 0; i < count; ++i) {
    next.tv_nsec += kPeriod_ns;
    if (next.tv_nsec >= 1'000'000'000) {
      next.tv_nsec -= 1'000'000'000;
      ++next.tv_sec;
    }
    while (::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &next, nullptr) != 0) {
    }
    const double due_s =
        static_cast<double>(next.tv_sec) + static_cast<double>(next.tv_nsec) * 1e-9;
    late_us.push_back((clock_s(CLOCK_MONOTONIC) - due_s) * 1e6);
  }
  return late_us;
}

std::string first_word(const std::filesystem::path& file) {
  std::ifstream in(file);
  std::string word;
  in >> word;
  return word;
}

std::vector<std::string> read_governors() {
  std::set<std::string> governors;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator("/sys/devices/system/cpu", error)) {
    const std::string word = first_word(entry.path() / "cpufreq/scaling_governor");
    if (!word.empty()) governors.insert(word);
  }
  return {governors.begin(), governors.end()};
}

DeviceFacts look_at_device(const std::string& path) {
  DeviceFacts facts;
  facts.path = path;
  struct stat status {};
  facts.exists = ::stat(path.c_str(), &status) == 0;
  if (!facts.exists) return facts;
  facts.usable = ::access(path.c_str(), R_OK | W_OK) == 0;
  if (const group* owner = ::getgrgid(status.st_gid)) facts.group = owner->gr_name;
  std::error_code error;
  const std::filesystem::path real = std::filesystem::canonical(path, error);
  const std::string timer =
      first_word("/sys/bus/usb-serial/devices" / real.filename() / "latency_timer");
  if (!timer.empty()) facts.latency_timer = std::atoi(timer.c_str());
  return facts;
}

/// The device of a serial link: the first word of its endpoint ("/dev/ttyACM0 921600").
std::vector<DeviceFacts> look_at_devices(const json& status) {
  std::vector<DeviceFacts> all;
  for (const json& link : status.value("links", json::array())) {
    const std::string endpoint = link.value("endpoint", "");
    if (link.value("type", "") != "serial" || endpoint.empty() || endpoint[0] != '/') continue;
    all.push_back(look_at_device(endpoint.substr(0, endpoint.find_first_of(" :"))));
  }
  return all;
}

void read_sys_hitl(Session& session, DoctorFacts& facts) {
  for (const json& vehicle : facts.after.value("vehicles", json::array())) {
    if (vehicle.value("autopilot", "") != "PX4" || vehicle.value("hil", false)) continue;
    const int system = vehicle.at("system");
    try {
      facts.sys_hitl[system] =
          session.call("param.get", {{"vehicle", system}, {"name", "SYS_HITL"}}).at("value");
    } catch (const base::rpc::CallError& error) {
      facts.unasked[system] = error.what();
    }
  }
}

void read_params(Session& session, DoctorFacts& facts) {
  for (const json& vehicle : facts.after.value("vehicles", json::array())) {
    if (!is_by_external_ahrs(facts, vehicle)) continue;
    const int system = vehicle.at("system");
    try {
      const json list = session.call("param.list", {{"vehicle", system}});
      for (const json& param : list.at("parameters")) {
        if (param.at("value").is_number()) facts.params[system][param.at("name")] = param["value"];
      }
    } catch (const base::rpc::CallError& error) {
      facts.unasked[system] = error.what();
    }
  }
}

std::string_view word(Health health) {
  constexpr base::EnumWords<Health::kBad> kWords{"good", "warning", "bad"};
  return kWords[health];
}

std::string_view mark(Health health) {
  constexpr base::EnumWords<Health::kBad> kMarks{"  ok   ", "  warn ", "  BAD  "};
  return kMarks[health];
}

int examine(Session& session, double seconds) {
  const std::vector<Finding> findings = diagnose(gather_facts(session, seconds));
  const bool ill = std::any_of(findings.begin(), findings.end(),
                               [](const Finding& f) { return f.health == Health::kBad; });
  json all = json::array();
  std::string text;
  for (const Finding& finding : findings) {
    all.push_back(
        {{"health", word(finding.health)}, {"what", finding.what}, {"remedy", finding.remedy}});
    text.append(mark(finding.health)).append(finding.what).append("\n");
    if (!finding.remedy.empty()) text += "         -> " + finding.remedy + "\n";
  }
  const bool unchecked = std::ranges::any_of(findings, &Finding::unchecked);
  const bool ready = !ill && !unchecked;
  text += ill ? "Not ready to fly: see the lines marked BAD, the first one first: those below may "
                "follow from it."
          : unchecked ? "Nothing wrong was found. Not every vehicle is in HIL: see above."
                      : "Ready to fly.";
  report(session.options(), {{"ready", ready}, {"findings", all}}, text);
  return ready ? kDone : kRefused;
}

}  // namespace

DoctorFacts gather_facts(Session& session, double seconds) {
  DoctorFacts facts;
  facts.before = session.call("casd.status");
  const double offset_s = wall_offset_s();
  const double start_s = clock_s(CLOCK_MONOTONIC);
  std::vector<double> late_us = measure_wake_ups(seconds);
  facts.seconds = clock_s(CLOCK_MONOTONIC) - start_s;
  facts.clock_step_s = wall_offset_s() - offset_s;
  facts.after = session.call("casd.status");
  facts.messages = all_messages(session);
  facts.routes = session.call("link.routes");
  std::sort(late_us.begin(), late_us.end());
  if (!late_us.empty()) {
    facts.wake_p99_us = late_us[late_us.size() * 99 / 100];
    facts.wake_max_us = late_us.back();
  }
  facts.governors = read_governors();
  facts.devices = look_at_devices(facts.after);
  read_sys_hitl(session, facts);
  read_params(session, facts);
  return facts;
}

void add_doctor_verb(CommandLine& line) {
  const auto seconds = std::make_shared<double>(2);
  line.add_verb("doctor", "Check the HIL set-up and say what is wrong, with the remedy",
                "casctl doctor", [seconds](Session& session) { return examine(session, *seconds); })
      ->add_option("--seconds", *seconds, "How long to watch")
      ->check(in_range(0.1, 600.0))
      ->capture_default_str();
}

}  // namespace cas::casctl
