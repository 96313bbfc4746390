// SPDX-License-Identifier: BSD-3-Clause
#include "casd/port/metrics.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <map>
#include <sstream>
#include <string>

namespace cas::casd::test {
namespace {

using std::chrono::microseconds;
using std::chrono::seconds;

MetricsSource with_forwarding(const base::Histogram& times) {
  LinkStatus link;
  link.name = "fcu";
  link.tx.forwarding = times.octaves();
  link.tx.forwarding_mean = times.mean();
  MetricsSource source{};
  source.links.push_back(link);
  return source;
}

/// The samples of a page by name and labels.
std::map<std::string, double> samples_of(const std::string& page) {
  std::map<std::string, double> samples;
  std::istringstream lines(page);
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with('#')) continue;
    const std::size_t space = line.rfind(' ');
    samples[line.substr(0, space)] = std::stod(line.substr(space + 1));
  }
  return samples;
}

// Dashboards know these names.
TEST(Metrics, CountersOfALinkKeepTheirNames) {
  LinkStatus link;
  link.name = "fcu";
  link.reconnects = 1;
  link.uncounted = 2;
  link.rx.packets = 3;
  link.rx.bytes = 4;
  link.rx.crc_errors = 5;
  link.rx.lost = 6;
  link.rx.not_accepted = 7;
  link.tx.packets = 8;
  link.tx.bytes = 9;
  link.tx.refused = 10;
  link.tx.queued = 11;
  link.tx.queue_high_water = 12;
  link.rx.kernel_drops = 13;
  MetricsSource source{};
  source.links.push_back(link);
  const auto samples = samples_of(metrics_text(source));
  double value = 0;
  for (const char* name :
       {"reconnects_total", "uncounted_total", "rx_packets_total", "rx_bytes_total",
        "rx_crc_errors_total", "rx_lost_total", "rx_not_accepted_total", "tx_packets_total",
        "tx_bytes_total", "tx_refused_total", "tx_queued", "tx_queue_high_water",
        "rx_kernel_drops_total"}) {
    EXPECT_EQ(samples.at("casd_link_" + std::string(name) + "{link=\"fcu\"}"), ++value) << name;
  }
}

TEST(Metrics, ForwardingTimesAreAHistogramWithTheSameBoundsAlways) {
  base::Histogram times;
  times.add(microseconds(10));
  times.add(microseconds(100));
  times.add(microseconds(110));
  times.add(seconds(1));
  const auto samples = samples_of(metrics_text(with_forwarding(times)));
  const std::string name = "casd_link_forwarding_seconds";
  const auto below = [&](const std::string& bound) {
    return samples.at(name + "_bucket{link=\"fcu\",le=\"" + bound + "\"}");
  };
  EXPECT_EQ(below("1.6384e-05"), 1);
  EXPECT_EQ(below("6.5536e-05"), 1);
  EXPECT_EQ(below("0.000131072"), 3);
  EXPECT_EQ(below("0.268435456"), 3);
  EXPECT_EQ(below("+Inf"), 4);
  EXPECT_EQ(samples.at(name + "_count{link=\"fcu\"}"), 4);
  EXPECT_NEAR(samples.at(name + "_sum{link=\"fcu\"}"), 1.00022, 1e-8)
      << "exact to a nanosecond each";
  EXPECT_EQ(samples_of(metrics_text(with_forwarding({}))).size(), samples.size());
}

TEST(Metrics, NothingButAHistogramOrASummaryHasQuantiles) {
  EXPECT_EQ(metrics_text(with_forwarding({})).find("quantile"), std::string::npos);
}

TEST(Metrics, TellOfEachVehicle) {
  MetricsSource source{};
  source.vehicles = {{.system = 1, .armed = true, .hil = true, .heartbeat_age_s = 0.25},
                     {.system = 7, .armed = false, .hil = false, .heartbeat_age_s = 12}};
  const auto samples = samples_of(metrics_text(source));
  EXPECT_EQ(samples.at("casd_vehicle_armed{system=\"1\"}"), 1);
  EXPECT_EQ(samples.at("casd_vehicle_armed{system=\"7\"}"), 0);
  EXPECT_EQ(samples.at("casd_vehicle_hil{system=\"1\"}"), 1);
  EXPECT_EQ(samples.at("casd_vehicle_heartbeat_age_seconds{system=\"7\"}"), 12);
}

TEST(Metrics, TellOfTheLogsOfAutopilots) {
  MetricsSource source{};
  EXPECT_EQ(metrics_text(source).find("casd_autopilot_log"), std::string::npos) << "none are taken";
  source.autopilot_logs.emplace();
  source.autopilot_logs->files.paused = "No space left on device";
  source.autopilot_logs->vehicles = {
      {.system = 1, .wanted = true, .file = LogFilesStatus::Entry{"v1.ulg", 120}, .trouble = {}},
      {.system = 2, .wanted = true, .file = {}, .trouble = {}}};
  const auto samples = samples_of(metrics_text(source));
  EXPECT_EQ(samples.at("casd_autopilot_logs_paused"), 1);
  EXPECT_EQ(samples.at("casd_autopilot_log_bytes{system=\"1\"}"), 120);
  EXPECT_EQ(samples.at("casd_autopilot_log_bytes{system=\"2\"}"), 0);
}

}  // namespace
}  // namespace cas::casd::test
