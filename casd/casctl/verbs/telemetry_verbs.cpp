// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <chrono>
#include <cmath>
#include <iostream>
#include <memory>
#include <thread>

#include "casd/casctl/session/text.hpp"
#include "casd/casctl/verbs/telemetry.hpp"
#include "casd/casctl/verbs/verbs.hpp"

namespace cas::casctl {
namespace {

using Clock = std::chrono::steady_clock;

struct WatchWish {
  std::vector<std::string> names;
  double rate_hz = 5;
  bool csv = false;
  int count = 0;     ///< 0: no end
  double for_s = 0;  ///< 0: no end
};

double unix_time_s() {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  return std::round(std::chrono::duration<double>(now).count() * 1000) / 1000;
}

/// A sample at each moment of a grid: late samples skip moments, and the rate stays.
class SampleGrid {
 public:
  explicit SampleGrid(double rate_hz) : period_s_(1 / rate_hz) {}

  /// When the next sample is due, s after the first.
  double next_s() const { return static_cast<double>(next_) * period_s_; }
  void wait() const {
    std::this_thread::sleep_until(start_ + std::chrono::duration_cast<Clock::duration>(
                                               std::chrono::duration<double>(next_s())));
  }
  double elapsed_s() const { return std::chrono::duration<double>(Clock::now() - start_).count(); }
  void advance() {
    next_ = std::max(next_ + 1, static_cast<std::int64_t>(std::ceil(elapsed_s() / period_s_)));
  }

 private:
  double period_s_;
  Clock::time_point start_ = Clock::now();
  std::int64_t next_ = 0;
};

int watch(Session& session, const WatchWish& wish) {
  if (wish.csv && session.options().json) {
    std::cerr << "casctl: give --csv or --json, not both\n";
    return kUsage;
  }
  const std::vector<TelemetryTopic> topics = chosen_topics(wish.names);
  const auto line_of = [&](const TelemetrySample& sample) {
    if (wish.csv) return csv_line(sample, topics);
    return session.options().json ? json_line(sample, topics)
                                  : printable_lines(text_lines(sample, topics));
  };
  session.vehicle_call("vehicle.telemetry");  // waits, where it should, before time counts
  if (wish.csv) std::cout << csv_header(topics) << '\n';
  SampleGrid grid(wish.rate_hz);
  for (int taken = 0; wish.count == 0 || taken < wish.count; ++taken) {
    if (wish.for_s > 0 && grid.next_s() >= wish.for_s) break;
    grid.wait();
    TelemetrySample sample;
    sample.answer = session.vehicle_call("vehicle.telemetry");
    sample.time_s = std::round(grid.elapsed_s() * 1000) / 1000;
    sample.unix_s = unix_time_s();
    if (!(std::cout << line_of(sample) << std::endl)) {
      throw std::runtime_error("the telemetry cannot be written: is the disk full?");
    }
    grid.advance();
  }
  return kDone;
}

std::string topic_help() {
  std::string usual;
  for (const TelemetryTopic& topic : chosen_topics({})) usual += " " + topic.name;
  std::string all;
  for (const std::string& name : telemetry_topic_names()) all += " " + name;
  return "Of" + all + "; left out:" + usual;
}

}  // namespace

void add_watch_verb(CommandLine& line) {
  const auto wish = std::make_shared<WatchWish>();
  CLI::App* const verb = line.add_verb(
      "watch", "Print what the vehicle measures, again and again",
      "casctl watch   or   casctl watch attitude battery --rate 10 --csv --for 60 > flight.csv",
      [wish](Session& session) { return watch(session, *wish); });
  verb->add_option("TOPIC", wish->names, topic_help())->check(one_of(telemetry_topic_names()));
  verb->add_option("--rate", wish->rate_hz, "Samples a second")
      ->check(in_range(0.01, 100.0))
      ->capture_default_str();
  verb->add_flag("--csv", wish->csv,
                 "A header and a line of values each time, separated by commas");
  verb->add_option("--count", wish->count, "End after this many samples; 0: never")
      ->check(CLI::NonNegativeNumber);
  verb->add_option("--for", wish->for_s, "End after this many seconds; 0: never")
      ->check(CLI::NonNegativeNumber);
}

}  // namespace cas::casctl
