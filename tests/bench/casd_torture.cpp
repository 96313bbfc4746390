// SPDX-License-Identifier: BSD-3-Clause
// Does to a running casd what a bench does to it, with HIL_SENSOR at 500 Hz going through, and
// prints losses and durations: the rows of docs/develop/results/casd_torture.md.
#include <signal.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "base/rpc/client.hpp"
#include "hils/programs/batch_progress.hpp"
#include "mavlink/common/all.hpp"
#include "tests/support/child_process.hpp"
#include "tests/support/free_port.hpp"
#include "tests/support/packet_stream.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/pty_pair.hpp"
#include "tests/support/supervisor.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/support/udp_peer.hpp"

namespace cas::test {
namespace {

using mavlink::common::HilSensor;
using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr auto kPeriod = milliseconds(2);

std::uint64_t micros(base::RunTime time) {
  return static_cast<std::uint64_t>(
      std::chrono::duration_cast<std::chrono::microseconds>(time.time_since_epoch()).count());
}

std::uint64_t now_us() { return micros(base::steady_now()); }

double quantile(std::vector<double> values, double q) {
  if (values.empty()) return std::nan("");
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(q * static_cast<double>(values.size() - 1) + 0.5)];
}

/// One HIL_SENSOR at the controller's end of the line.
struct Arrival {
  std::uint64_t sent_us = 0;
  std::uint64_t came_us = 0;

  double delay_ms() const { return static_cast<double>(came_us - sent_us) / 1000; }
};

/// A simulator that sends HIL_SENSOR without a pause and a line that notes what comes.
class Stream {
 public:
  explicit Stream(std::uint16_t casd_port) : fcu(folder / "fcu0") {
    sim_.set_remote(casd_port);
    sender_ = std::thread([this] { send(); });
    reader_ = std::thread([this] { read(); });
  }
  ~Stream() {
    ending_.store(true);
    sender_.join();
    reader_.join();
  }
  Stream(const Stream&) = delete;
  Stream& operator=(const Stream&) = delete;

  std::string endpoint() const { return sim_.endpoint(); }

  std::vector<Arrival> arrivals() {
    const std::lock_guard lock(mutex_);
    return arrivals_;
  }
  void forget() {
    const std::lock_guard lock(mutex_);
    arrivals_.clear();
    sent_us_.clear();
  }
  /// The first arrival of what was sent after `us`; nothing at the deadline.
  std::optional<Arrival> first_after(std::uint64_t us) {
    std::optional<Arrival> found;
    wait_until([&] {
      const std::lock_guard lock(mutex_);
      for (auto at = arrivals_.rbegin(); at != arrivals_.rend() && at->sent_us > us; ++at) {
        found = *at;
      }
      return found.has_value();
    });
    return found;
  }
  /// Packets sent since `forget` that have not come, after a moment for those on their way.
  std::size_t lost() {
    const std::uint64_t until = now_us();
    if (!first_after(until)) return ~std::size_t{0};
    const std::lock_guard lock(mutex_);
    const auto sent = std::count_if(sent_us_.begin(), sent_us_.end(),
                                    [until](std::uint64_t us) { return us <= until; });
    const auto came = std::count_if(arrivals_.begin(), arrivals_.end(),
                                    [until](const Arrival& one) { return one.sent_us <= until; });
    return static_cast<std::size_t>(std::max<std::ptrdiff_t>(0, sent - came));
  }
  /// The line is pulled and comes back. @return the moment before it did
  std::uint64_t replug(base::Duration gone) {
    const std::lock_guard lock(line_mutex_);
    fcu.hang_up();
    std::this_thread::sleep_for(gone);
    stream_ = {};
    const std::uint64_t before = now_us();
    fcu.come_back();
    return before;
  }

  TemporaryFolder folder;
  PtyPair fcu;

 private:
  void send() {
    mav::Encoder encoder{{1, 200}};
    base::RunTime next = base::steady_now();
    while (!ending_.load()) {
      HilSensor message;
      message.time_usec = now_us();
      message.zacc = -9.8F;
      sim_.send(encoder(message));
      {
        const std::lock_guard lock(mutex_);
        sent_us_.push_back(message.time_usec);
      }
      next += kPeriod;
      std::this_thread::sleep_for(next - base::steady_now());
    }
  }
  void read() {
    while (!ending_.load()) {
      {
        const std::lock_guard lock(line_mutex_);
        fcu.read(stream_);
      }
      const std::uint64_t came = now_us();
      {
        const std::lock_guard lock(mutex_);
        for (const PacketStream::Packet& packet : stream_.packets()) {
          if (packet.message_id != HilSensor::kId) continue;
          const auto sensor = mav::decode<HilSensor>(packet.view());
          if (sensor) arrivals_.push_back({sensor->time_usec, came});
        }
      }
      stream_.packets().clear();
      std::this_thread::sleep_for(std::chrono::microseconds(500));
    }
  }

  UdpPeer sim_;
  PacketStream stream_;  // of the reader
  std::mutex line_mutex_;
  std::mutex mutex_;
  std::vector<Arrival> arrivals_;
  std::vector<std::uint64_t> sent_us_;
  std::atomic<bool> ending_{false};
  std::thread sender_;
  std::thread reader_;
};

/// casd under its unit file, with the stream through it.
class Bench {
 public:
  /// @param launcher  words before casd's own, e.g. a limit on descriptors
  explicit Bench(std::vector<std::string> launcher = {}) {
    topology_ = stream.folder.write("casd.yaml", yaml(false)).string();
    UnitFile unit = UnitFile::load(source_dir() + "/config/systemd/casd.service");
    std::string command;
    for (const std::string& word : launcher) command += word + " ";
    unit.settings["ExecStart"] = {command + unit.value("ExecStart")};
    unit.settings["StartLimitIntervalSec"] = {"0"};
    service = std::make_unique<Supervisor>(
        unit, std::map<std::string, std::string>{{"/usr/bin/casd", binary_dir() + "/bin/casd"},
                                                 {"/etc/cas/casd.yaml", topology_}});
    if (!service->wait_ready() || !stream.first_after(now_us())) {
      throw std::runtime_error(service->output());
    }
    stream.forget();
  }

  base::rpc::Client client() const {
    return base::rpc::Client("unix:" + (stream.folder / "casd.sock").string());
  }
  /// Writes the topology with or without one more link and reloads it.
  void reload(base::rpc::Client& client, bool one_more) {
    stream.folder.write("casd.yaml", yaml(one_more));
    client.call("casd.reload", base::rpc::Json::object());
  }

  const std::uint16_t sim_port = free_port();
  const std::uint16_t gcs_port = free_port();
  Stream stream{sim_port};
  std::unique_ptr<Supervisor> service;

 private:
  std::string yaml(bool one_more) const {
    return "schema: 1\n"
           "command_port: {port: 0, unix: " +
           (stream.folder / "casd.sock").string() +
           "}\n"
           "links:\n"
           "  - {name: sim, type: udp, local: '127.0.0.1:" +
           std::to_string(sim_port) + "', remote: '" + stream.endpoint() +
           "'}\n"
           "  - {name: fcu, type: serial, device: " +
           (stream.folder / "fcu0").string() +
           ", baud: 921600}\n"
           "  - {name: gcs, type: udp_server, local: '127.0.0.1:" +
           std::to_string(gcs_port) + "'}\n" +
           (one_more ? "  - {name: more, type: udp_server, local: '127.0.0.1:0'}\n" : "") +
           "routes:\n"
           "  - {from: sim, to: fcu, allow: [HEARTBEAT, HIL_SENSOR, HIL_GPS]}\n"
           "  - {from: sim, to: gcs, allow: [HIL_SENSOR]}\n"
           "  - {from: gcs, to: fcu, block: [HIL_SENSOR, HIL_GPS]}\n";
  }

  std::string topology_;
};

void row(const std::string& what, const std::string& seen) {
  std::printf("| %s | %s |\n", what.c_str(), seen.c_str());
  std::fflush(stdout);
}

std::string text(const char* format, double a, double b = 0) {
  char buffer[160];
  std::snprintf(buffer, sizeof buffer, format, a, b);
  return buffer;
}

std::string delays(const std::vector<Arrival>& arrivals) {
  std::vector<double> ms;
  for (const Arrival& one : arrivals) ms.push_back(one.delay_ms());
  return text("delay p50 %.2f ms, p99 %.2f ms", quantile(ms, 0.5), quantile(ms, 0.99));
}

void kill(int times) {
  Bench bench;
  std::vector<double> gap_ms;
  std::size_t old = 0;
  for (int i = 0; i < times; ++i) {
    const std::uint64_t killed = micros(bench.service->signal(SIGKILL));
    const auto back = bench.stream.first_after(killed);
    if (!back) throw std::runtime_error("casd did not come back: " + bench.service->output());
    gap_ms.push_back(static_cast<double>(back->came_us - killed) / 1000);
    bench.service->wait_ready();
    std::this_thread::sleep_for(milliseconds(300));
  }
  const auto arrivals = bench.stream.arrivals();
  for (std::size_t i = 1; i < arrivals.size(); ++i) {
    old += arrivals[i].sent_us < arrivals[i - 1].sent_us ? 1 : 0;
  }
  row("kill -9 of casd under its unit, x " + std::to_string(times),
      text("death to the first fresh HIL_SENSOR p50 %.0f ms, max %.0f ms; ", quantile(gap_ms, 0.5),
           quantile(gap_ms, 1)) +
          std::to_string(old) + " out of order");
}

void restart(int times) {
  Bench bench;
  std::vector<double> gap_ms;
  for (int i = 0; i < times; ++i) {
    const std::size_t before = bench.stream.arrivals().size();
    bench.service->restart();
    bench.service->wait_ready();
    bench.stream.first_after(now_us());
    const auto arrivals = bench.stream.arrivals();
    std::uint64_t longest = 0;
    for (std::size_t j = std::max<std::size_t>(before, 1); j < arrivals.size(); ++j) {
      longest = std::max(longest, arrivals[j].came_us - arrivals[j - 1].came_us);
    }
    gap_ms.push_back(static_cast<double>(longest) / 1000);
    std::this_thread::sleep_for(milliseconds(300));
  }
  row("restart of the service, x " + std::to_string(times),
      text("longest gap between two HIL_SENSOR p50 %.0f ms, max %.0f ms", quantile(gap_ms, 0.5),
           quantile(gap_ms, 1)));
}

void replug(int times) {
  Bench bench;
  std::vector<double> back_ms;
  std::size_t stale = 0;
  for (int i = 0; i < times; ++i) {
    const std::size_t before = bench.stream.arrivals().size();
    const std::uint64_t back = bench.stream.replug(milliseconds(200));
    const auto first = bench.stream.first_after(back);
    if (!first) throw std::runtime_error("the line did not come back");
    back_ms.push_back(static_cast<double>(first->came_us - back) / 1000);
    const auto arrivals = bench.stream.arrivals();
    for (std::size_t j = before; j < arrivals.size(); ++j) {
      stale += arrivals[j].came_us >= back && arrivals[j].sent_us < back ? 1 : 0;
    }
  }
  row("line pulled for 0.2 s and plugged in again, x " + std::to_string(times),
      text("back p50 %.1f ms, max %.1f ms; ", quantile(back_ms, 0.5), quantile(back_ms, 1)) +
          std::to_string(stale) + " HIL_SENSOR from before the pull");
}

void reload(int times) {
  Bench bench;
  base::rpc::Client client = bench.client();
  for (int i = 0; i < times; ++i) bench.reload(client, i % 2 == 0);
  const std::size_t sent = bench.stream.arrivals().size();
  row("reload that adds or removes a link, one after the other, x " + std::to_string(times),
      std::to_string(bench.stream.lost()) + " of " + std::to_string(sent) + " HIL_SENSOR lost; " +
          delays(bench.stream.arrivals()));
}

void stations(int many) {
  Bench bench;
  std::vector<std::unique_ptr<UdpPeer>> peers;
  std::vector<PacketStream> heard(static_cast<std::size_t>(many));
  mav::Encoder encoder{{255, 190}};
  for (int i = 0; i < many; ++i) {
    peers.push_back(std::make_unique<UdpPeer>());
    peers.back()->set_remote(bench.gcs_port);
  }
  const base::RunTime end = base::steady_now() + seconds(5);
  while (base::steady_now() < end) {
    for (std::size_t i = 0; i < peers.size(); ++i) {
      peers[i]->send(encoder(mavlink::common::Heartbeat{}));
      peers[i]->read(heard[i]);
    }
    std::this_thread::sleep_for(milliseconds(50));
  }
  const std::size_t sent = bench.stream.arrivals().size();
  const auto served = std::count_if(heard.begin(), heard.end(), [](const PacketStream& one) {
    return one.count(HilSensor::kId) > 0;
  });
  row(std::to_string(many) + " ground stations on one UDP port, 5 s",
      std::to_string(served) + " served; " + std::to_string(bench.stream.lost()) + " of " +
          std::to_string(sent) + " HIL_SENSOR lost at the controller; " +
          delays(bench.stream.arrivals()));
}

/// HIL while four threads ask without a pause. @param ask  one request, on a thread's own
/// connection
void while_asked(const std::string& what, Bench& bench,
                 const std::function<std::function<void()>()>& connect) {
  std::this_thread::sleep_for(seconds(5));
  const std::string quiet = delays(bench.stream.arrivals());
  bench.stream.forget();
  std::atomic<bool> over{false};
  std::atomic<int> answers{0};
  std::atomic<int> refused{0};
  std::vector<std::thread> pollers;
  for (int i = 0; i < 4; ++i) {
    pollers.emplace_back([&] {
      while (!over.load()) {
        try {
          const auto ask = connect();
          while (!over.load()) {
            ask();
            ++answers;
          }
        } catch (const std::exception&) {
          ++refused;
          std::this_thread::sleep_for(milliseconds(1));
        }
      }
    });
  }
  std::this_thread::sleep_for(seconds(5));
  const std::string asked = delays(bench.stream.arrivals());
  over.store(true);
  for (std::thread& poller : pollers) poller.join();
  row(what + ", four clients without a pause, 5 s",
      std::to_string(answers.load() / 5) + " answers/s, " + std::to_string(refused.load()) +
          " refused; " + std::to_string(bench.stream.lost()) + " lost; " + asked +
          " (without: " + quiet + ")");
}

void requests() {
  Bench bench;
  while_asked("`casd.status` on the command port", bench, [&bench]() -> std::function<void()> {
    const auto client = std::make_shared<base::rpc::Client>(bench.client());
    return [client] { client->call("casd.status", base::rpc::Json::object()); };
  });
}

/// The limit is the shell's: casd cannot have more descriptors than that.
void descriptors() {
  Bench bench({"/usr/bin/prlimit", "--nofile=64:64"});
  std::vector<std::unique_ptr<base::rpc::Client>> clients;
  int connected = 0;
  for (int i = 0; i < 200; ++i) {
    try {
      clients.push_back(std::make_unique<base::rpc::Client>(bench.client()));
      clients.back()->call("casd.status", base::rpc::Json::object(), milliseconds(200));
      ++connected;
    } catch (const std::exception&) {
      continue;
    }
  }
  const std::size_t sent = bench.stream.arrivals().size();
  const std::size_t lost = bench.stream.lost();
  clients.clear();
  const bool answers = wait_until([&] {
    try {
      bench.client().call("casd.status", base::rpc::Json::object());
      return true;
    } catch (const std::exception&) {
      return false;
    }
  });
  row("`ulimit -n 64` and 200 command connections",
      std::to_string(connected) + " answered; " + std::to_string(lost) + " of " +
          std::to_string(sent) + " HIL_SENSOR lost; afterwards casd " +
          (answers ? "answers" : "DOES NOT ANSWER") + ", " +
          std::to_string(bench.service->starts() - 1) + " restarts");
}

/// The wall clock of casd alone is stepped, by libfaketime.
void clock_steps(int times) {
  const char* const library = "/usr/lib/x86_64-linux-gnu/faketime/libfaketime.so.1";
  if (!std::filesystem::exists(library)) {
    return row("wall clock stepped by a day", "not tried: libfaketime is not installed");
  }
  TemporaryFolder folder;
  const std::string file = folder.write("clock", "+0\n").string();
  Bench bench({"/usr/bin/env", std::string("LD_PRELOAD=") + library, "FAKETIME_NO_CACHE=1",
               "FAKETIME_DONT_FAKE_MONOTONIC=1", "FAKETIME_TIMESTAMP_FILE=" + file});
  for (int i = 0; i < times; ++i) {
    folder.write("clock", i % 2 == 0 ? "+1d\n" : "-1d\n");
    std::this_thread::sleep_for(milliseconds(300));
  }
  const std::size_t sent = bench.stream.arrivals().size();
  row("wall clock stepped by two days to and fro, x " + std::to_string(times),
      std::to_string(bench.stream.lost()) + " of " + std::to_string(sent) + " HIL_SENSOR lost; " +
          delays(bench.stream.arrivals()) + "; " + std::to_string(bench.service->starts() - 1) +
          " restarts");
}

int run(const std::vector<std::string>& only) {
  const std::vector<std::pair<std::string, std::function<void()>>> all = {
      {"kill", [] { kill(50); }},
      {"restart", [] { restart(20); }},
      {"replug", [] { replug(50); }},
      {"reload", [] { reload(200); }},
      {"stations",
       [] {
         stations(64);
         stations(200);
       }},
      {"requests", requests},
      {"descriptors", descriptors},
      {"clock", [] { clock_steps(10); }}};
  const auto wanted = [&only](const auto& entry) {
    return only.empty() || std::find(only.begin(), only.end(), entry.first) != only.end();
  };
  const auto count = static_cast<std::size_t>(std::count_if(all.begin(), all.end(), wanted));
  const auto begin = std::chrono::steady_clock::now();
  std::size_t done = 0;
  std::printf("| what | seen |\n|---|---|\n");
  for (const auto& entry : all) {
    if (!wanted(entry)) continue;
    const auto elapsed =
        std::chrono::duration_cast<std::chrono::seconds>(std::chrono::steady_clock::now() - begin);
    std::fprintf(stderr, "%s; %s\n",
                 hils::batch_line("casd_torture", done++, count, elapsed).c_str(),
                 entry.first.c_str());
    entry.second();
  }
  return 0;
}

}  // namespace
}  // namespace cas::test

int main(int argc, char** argv) {
  CLI::App cli("Does to casd what a bench does to it, and prints what was lost.", "casd_torture");
  std::vector<std::string> only;
  cli.add_option("--only", only,
                 "kill, restart, replug, reload, stations, requests, descriptors, clock")
      ->delimiter(',');
  CLI11_PARSE(cli, argc, argv);
  try {
    return cas::test::run(only);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "casd_torture: %s\n", error.what());
    return 1;
  }
}
