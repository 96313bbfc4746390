// SPDX-License-Identifier: BSD-3-Clause
#include "casd/port/metrics.hpp"

#include <fmt/format.h>
#include <string_view>
#include <utility>

#include "casd/queue/tx_queue.hpp"
#include "casd/routing/router.hpp"

namespace cas::casd {
namespace {

/// A label's value: names may hold anything.
std::string label_value(std::string_view value) {
  std::string text = "\"";
  for (const char c : value) {
    if (c == '\n') {
      text += "\\n";
      continue;
    }
    if (c == '"' || c == '\\') text += '\\';
    text += c;
  }
  return text + '"';
}

std::string number(double value) { return fmt::format("{:.9g}", value); }

/// Collects the samples of one metric below its header.
class Metric {
 public:
  Metric(std::string& out, std::string name, std::string_view type, std::string_view help)
      : out_(out), name_(std::move(name)) {
    out_ += "# HELP " + name_ + " " + std::string(help) + "\n";
    out_ += "# TYPE " + name_ + " " + std::string(type) + "\n";
  }
  void add(const std::string& labels, std::uint64_t value) { add_part("", labels, value); }
  void add(const std::string& labels, double value) { add_part("", labels, value); }
  /// A sample of a histogram: "_bucket", "_sum" or "_count".
  void add_part(const char* part, const std::string& labels, std::uint64_t value) {
    write(part, labels, std::to_string(value));
  }
  void add_part(const char* part, const std::string& labels, double value) {
    write(part, labels, number(value));
  }

 private:
  void write(const char* part, const std::string& labels, const std::string& value) {
    out_ += name_ + part + (labels.empty() ? "" : "{" + labels + "}") + " " + value + "\n";
  }
  std::string& out_;
  const std::string name_;
};

std::string link_label(const LinkStatus& link) { return "link=" + label_value(link.name); }

void add_states(std::string& out, const MetricsSource& source) {
  Metric up(out, "casd_link_up", "gauge", "1 while the link is up.");
  for (const LinkStatus& link : source.links) {
    up.add(link_label(link) + ",type=" + label_value(to_string(link.type)),
           std::uint64_t{link.state == LinkState::kUp ? 1U : 0U});
  }
  for (const LinkCounterRow& row : link_counter_rows()) {
    const CounterWords& words = row.words;
    const bool total = words.kind == CounterWords::Kind::kTotal;
    Metric metric(out,
                  "casd_link_" + std::string(words.group) + (words.group.empty() ? "" : "_") +
                      std::string(words.key) + (total ? "_total" : ""),
                  total ? "counter" : "gauge", words.help);
    for (const LinkStatus& link : source.links) metric.add(link_label(link), row.value(link));
  }
}

void add_drops(std::string& out, const MetricsSource& source) {
  Metric received(out, "casd_link_rx_verdicts_total", "counter", "Where received packets ended.");
  for (const LinkStatus& link : source.links) {
    for (std::size_t i = 0; i < link.rx.decisions.size(); ++i) {
      const std::string_view decision = to_string(static_cast<Route::Decision>(i));
      received.add(link_label(link) + ",verdict=" + label_value(decision), link.rx.decisions[i]);
    }
  }
  Metric dropped(out, "casd_link_tx_dropped_total", "counter", counter_words("tx", "dropped").help);
  for (const LinkStatus& link : source.links) {
    for (std::size_t i = 0; i < link.tx.dropped.size(); ++i) {
      const std::string_view cause = to_string(static_cast<DropCause>(i));
      dropped.add(link_label(link) + ",cause=" + label_value(cause), link.tx.dropped[i]);
    }
  }
}

/// Forwarding times of a link as a histogram. Its bounds are those of the octaves (powers of two in
/// ns), from 16 us to 0.27 s, whatever has been seen: a scraper wants the same ones each time.
void add_forwarding(Metric& time, const LinkStatus& link) {
  constexpr int kFirst = 14;
  constexpr int kLast = 28;
  std::uint64_t total = 0;
  for (const base::Histogram::Bin& bin : link.tx.forwarding) total += bin.count;
  for (int octave = kFirst; octave <= kLast; ++octave) {
    const base::Duration bound(std::int64_t{1} << octave);
    std::uint64_t below = 0;
    for (const base::Histogram::Bin& bin : link.tx.forwarding) {
      if (bin.upper <= bound) below += bin.count;
    }
    time.add_part("_bucket", link_label(link) + ",le=\"" + number(base::to_seconds(bound)) + "\"",
                  below);
  }
  time.add_part("_bucket", link_label(link) + ",le=\"+Inf\"", total);
  time.add_part("_sum", link_label(link),
                base::to_seconds(link.tx.forwarding_mean) * static_cast<double>(total));
  time.add_part("_count", link_label(link), total);
}

void add_vehicles(std::string& out, const std::vector<VehicleMetrics>& vehicles) {
  const auto gauge = [&](const char* name, const char* help, auto member) {
    Metric all(out, name, "gauge", help);
    for (const VehicleMetrics& vehicle : vehicles) {
      all.add(fmt::format("system=\"{}\"", vehicle.system), static_cast<double>(vehicle.*member));
    }
  };
  gauge("casd_vehicle_armed", "1 while the vehicle says that it is armed.", &VehicleMetrics::armed);
  gauge("casd_vehicle_hil", "1 while the vehicle says that it is in HIL.", &VehicleMetrics::hil);
  gauge("casd_vehicle_heartbeat_age_seconds", "Since the vehicle's newest HEARTBEAT.",
        &VehicleMetrics::heartbeat_age_s);
}

void add_recording(std::string& out, const TlogStatus& recording) {
  const auto gauge = [&out](const char* name, const char* help, std::uint64_t value) {
    Metric(out, name, "gauge", help).add("", value);
  };
  gauge("casd_recording_active", "1 while a telemetry log is recorded.", recording.active ? 1 : 0);
  gauge("casd_recording_paused", "1 while the disk does not take what is recorded.",
        recording.paused ? 1 : 0);
  gauge("casd_recording_packets", "Packets in the files of the recording.", recording.recorded);
  gauge("casd_recording_left_out", "Packets that are missing in the recording.",
        recording.left_out);
}

void add_autopilot_logs(std::string& out, const AutopilotLogsStatus& logs) {
  Metric(out, "casd_autopilot_logs_paused", "gauge",
         "1 while the disk does not take the logs of autopilots.")
      .add("", std::uint64_t{logs.files.paused ? 1U : 0U});
  Metric bytes(out, "casd_autopilot_log_bytes", "gauge",
               "Bytes in the file of a vehicle's log; 0: it has none.");
  for (const AutopilotLogStatus& log : logs.vehicles) {
    bytes.add(fmt::format("system=\"{}\"", log.system),
              log.file ? log.file->bytes : std::uint64_t{0});
  }
}

void add_messages(std::string& out, const MetricsSource& source) {
  Metric(out, "casd_messages_cut", "gauge",
         "1 where casd_messages_total lacks some: too many kinds.")
      .add("", std::uint64_t{source.messages_cut ? 1U : 0U});
  Metric messages(out, "casd_messages_total", "counter", "Packets by link, message and sender.");
  for (const MessageStatus& message : source.messages) {
    const std::string name = message.name.empty() ? std::to_string(message.id) : message.name;
    messages.add(fmt::format("link={},direction={},message={},system=\"{}\",component=\"{}\"",
                             label_value(message.link), label_value(to_string(message.way)),
                             label_value(name), message.source.system, message.source.component),
                 message.count);
  }
}

}  // namespace

std::string metrics_text(const MetricsSource& source) {
  std::string out;
  Metric(out, "casd_uptime_seconds", "gauge", "Since the start.").add("", source.uptime_s);
  Metric(out, "casd_command_clients", "gauge", "Clients of the command port.")
      .add("", std::uint64_t{source.clients});
  Metric refused(out, "casd_command_refused_total", "counter",
                 "Clients that the command port refused.");
  for (const auto& [reason, count] : source.refused) {
    refused.add("reason=" + label_value(reason), count);
  }
  add_states(out, source);
  add_drops(out, source);
  Metric time(out, "casd_link_forwarding_seconds", "histogram",
              "From read on another link to written on this one, since the start.");
  for (const LinkStatus& link : source.links) add_forwarding(time, link);
  add_vehicles(out, source.vehicles);
  add_recording(out, source.recording);
  if (source.autopilot_logs) add_autopilot_logs(out, *source.autopilot_logs);
  add_messages(out, source);
  return out;
}

}  // namespace cas::casd
