// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <poll.h>
#include <signal.h>

#include <atomic>
#include <chrono>
#include <filesystem>
#include <mutex>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "tests/loopback/casd_fixture.hpp"
#include "tests/loopback/running_casd.hpp"
#include "tests/loopback/tcp_peer.hpp"

namespace cas::test {
namespace {

using std::chrono::milliseconds;

constexpr std::uint32_t kManualControl = mavlink::common::ManualControl::kId;
constexpr std::uint32_t kCommandLong = mavlink::common::CommandLong::kId;

constexpr base::Duration kSensorAge = milliseconds(25);  // the defaults of `queue`
constexpr base::Duration kStickAge = milliseconds(500);
constexpr base::Duration kStall = milliseconds(2000);
/// Most that a busy machine may add to any time.
constexpr base::Duration kBusy = milliseconds(300);

mavlink::common::ManualControl stick(std::uint64_t number) {
  return {.target = 1, .x = static_cast<std::int16_t>(number), .z = 500};
}

/// A simulator that sends 500 HIL_SENSOR a second, and a ground station with 40 stick positions,
/// each with its number.
class Streams {
 public:
  Streams(UdpPeer& sim, UdpPeer& station) : sim_(sim), station_(station) {
    thread_ = std::thread([this] { run(); });
  }
  ~Streams() {
    stop_ = true;
    thread_.join();
  }
  base::RunTime sent_at(std::uint32_t message, std::uint64_t number) const {
    const std::scoped_lock lock(mutex_);
    return (message == kHilSensor ? sensors_ : sticks_).at(number);
  }
  /// Stick positions so far.
  std::uint64_t sticks() const {
    const std::scoped_lock lock(mutex_);
    return sticks_.size();
  }

 private:
  void run() {
    mav::Encoder from_sim({1, 200});
    mav::Encoder from_station({255, 190});
    const base::RunTime begin = base::steady_now();
    for (int tick = 0; !stop_;) {
      constexpr base::Duration kTick = milliseconds(2);
      for (; base::steady_now() - begin >= tick * kTick; ++tick) {
        sim_.send(from_sim(hil_sensor(add(sensors_))));
        constexpr int kSensorsPerStick = 12;
        if (tick % kSensorsPerStick == 0) station_.send(from_station(stick(add(sticks_))));
      }
      ::poll(nullptr, 0, 1);
    }
  }
  std::uint64_t add(std::vector<base::RunTime>& sent) {
    const std::scoped_lock lock(mutex_);
    sent.push_back(base::steady_now());
    return sent.size() - 1;
  }

  UdpPeer& sim_;
  UdpPeer& station_;
  mutable std::mutex mutex_;
  std::vector<base::RunTime> sensors_;
  std::vector<base::RunTime> sticks_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

/// Packets that the controller read, with their times.
class Controller {
 public:
  struct Arrival {
    std::uint32_t message = 0;
    std::uint64_t number = 0;
    base::RunTime at;  ///< it had not come before this: a test that has to wait makes nothing old
  };
  explicit Controller(PtyPair& line) : line_(line) {}

  void read() {
    const base::RunTime earliest = std::exchange(last_read_, base::steady_now());
    line_.read(stream_);
    for (const PacketStream::Packet& packet : stream_.packets()) {
      arrivals_.push_back({packet.message_id, number_of(packet.view()), earliest});
    }
    stream_.packets().clear();
  }
  template <class Condition>
  bool read_until(Condition&& condition) {
    return wait_until([&] {
      read();
      return condition();
    });
  }
  bool read_for(base::Duration time) {
    const base::RunTime end = base::steady_now() + time;
    return read_until([&] { return base::steady_now() > end; });
  }
  std::size_t count(std::uint32_t message) const {
    std::size_t n = 0;
    for (const Arrival& arrival : arrivals_) n += arrival.message == message ? 1 : 0;
    return n;
  }
  const std::vector<Arrival>& arrivals() const { return arrivals_; }
  void forget() { arrivals_.clear(); }

 private:
  static std::uint64_t number_of(const mav::PacketView& packet) {
    if (const auto sensor = mav::decode<mavlink::common::HilSensor>(packet)) {
      return sensor->time_usec;
    }
    const auto manual = mav::decode<mavlink::common::ManualControl>(packet);
    return manual ? static_cast<std::uint64_t>(manual->x) : 0;
  }
  PtyPair& line_;
  PacketStream stream_;
  std::vector<Arrival> arrivals_;
  base::RunTime last_read_ = base::steady_now();
};

/// How many packets of a message came that were sent after `from` and were too old when they came.
std::size_t count_stale(const Controller& controller, const Streams& streams, std::uint32_t message,
                        base::RunTime from) {
  const base::Duration limit = (message == kHilSensor ? kSensorAge : kStickAge) + kBusy;
  std::size_t stale = 0;
  for (const Controller::Arrival& arrival : controller.arrivals()) {
    if (arrival.message != message) continue;
    const base::RunTime sent = streams.sent_at(message, arrival.number);
    stale += sent > from && arrival.at - sent > limit ? 1 : 0;
  }
  return stale;
}

/// How many came that were sent between two moments.
std::size_t count_sent_in(const Controller& controller, const Streams& streams,
                          std::uint32_t message, base::RunTime from, base::RunTime to) {
  std::size_t n = 0;
  for (const Controller::Arrival& arrival : controller.arrivals()) {
    if (arrival.message != message) continue;
    const base::RunTime sent = streams.sent_at(message, arrival.number);
    n += sent > from && sent < to ? 1 : 0;
  }
  return n;
}

bool newest_came(const Controller& controller, const Streams& streams, std::uint32_t message,
                 base::RunTime since) {
  for (const Controller::Arrival& arrival : controller.arrivals()) {
    if (arrival.message == message && streams.sent_at(message, arrival.number) >= since) {
      return true;
    }
  }
  return false;
}

/// @param more  keys of the line: ", key: value"
std::string topology_with(const std::string& threads, const std::string& more = "") {
  return "schema: 1\ncommand_port: {port: 0, loopback_without_token: true}\ndrain_tick_ms: "
         "0\nthreads: " +
         threads + R"(
links:
  - {name: sim, type: udp, local: "127.0.0.1:0", remote: "$SIM"}
  - {name: fcu, type: serial, device: "$FCU", baud: 921600)" +
         more + R"(}
  - {name: gcs, type: udp_server, local: "127.0.0.1:0"}
  - {name: tcp, type: tcp_server, local: "127.0.0.1:0"}
)";
}

/// Waits until casd gives the controller nothing for longer than it rests between two packets. It
/// counts looks, not time: a stall of the whole machine proves nothing.
bool takes_no_more(CasdFixture& fixture) {
  constexpr int kLooks = 250;  // 2 ms apart and more
  std::uint64_t sent = 0;
  int same = 0;
  return wait_until([&] {
    const std::uint64_t now_sent = fixture.status("fcu").tx.packets;
    same = std::exchange(sent, now_sent) == now_sent ? same + 1 : 0;
    return same > kLooks;
  });
}

class CasdAge : public testing::TestWithParam<const char*> {};

TEST_P(CasdAge, NothingOldComesWhenAReaderReadsAgain) {
  CasdFixture fixture(topology_with(GetParam()));
  UdpPeer station;
  UdpPeer other_station;
  station.set_remote(fixture.port("gcs"));
  other_station.set_remote(fixture.port("gcs"));
  fixture.fcu.write(fixture.from_fcu(mavlink::common::Heartbeat{}));
  ASSERT_TRUE(wait_until([&] { return fixture.status("fcu").rx.packets == 1; }));
  Controller controller(fixture.fcu);
  Streams streams(fixture.sim, station);
  ASSERT_TRUE(controller.read_until(
      [&] { return controller.count(kHilSensor) > 50 && controller.count(kManualControl) > 5; }));

  // The reader stops. Packets that casd wrote before it could know of that are out of its reach: on
  // a busy machine this takes a while, because slow writes leave it in doubt.
  controller.forget();
  ASSERT_TRUE(takes_no_more(fixture));
  const base::RunTime known = base::steady_now();
  mavlink::common::CommandLong command{.target_system = 1};
  mav::Encoder from_other({254, 190});
  other_station.send(from_other(command));
  ASSERT_TRUE(wait_until([&] { return base::steady_now() - known > kStall; }));

  const base::RunTime reads = base::steady_now();
  ASSERT_TRUE(controller.read_until([&] {
    return newest_came(controller, streams, kHilSensor, reads) &&
           newest_came(controller, streams, kManualControl, reads);
  }));
  // A busy kernel may leave the terminal's bytes lying for so long that casd empties it again, and
  // the command with it.
  const bool came_at_once = base::steady_now() - reads < std::chrono::seconds(1);
  ASSERT_TRUE(controller.read_for(milliseconds(100)));
  EXPECT_EQ(count_stale(controller, streams, kHilSensor, known), 0U);
  EXPECT_EQ(count_stale(controller, streams, kManualControl, known), 0U);
  EXPECT_LE(count_sent_in(controller, streams, kManualControl, known, reads), 5U)
      << "of those that waited the newest only";
  const bool waits_for_the_line = std::string(GetParam()) == "blocking";
  if (!waits_for_the_line && came_at_once) {
    EXPECT_EQ(controller.count(kCommandLong), 1U);
  }
  const auto& dropped = fixture.status("fcu").tx.dropped;
  EXPECT_GT(dropped[static_cast<std::size_t>(casd::DropCause::kAge)], 0U);
  const auto in_the_terminal = [&](std::uint32_t message) {
    return static_cast<int>(count_sent_in(controller, streams, message, base::RunTime{}, known));
  };
  RecordProperty("sensors_in_the_terminal", in_the_terminal(kHilSensor));
  RecordProperty("sticks_in_the_terminal", in_the_terminal(kManualControl));
}

/// The real program, for behaviour that only a stopped process or its log shows.
class CasdProgram {
 public:
  explicit CasdProgram(const std::string& threads, const std::string& more = "")
      : casd({kCasdProgram, fixture.folder.write("topology.yaml",
                                                 fixture.expand(topology_with(threads, more)))}) {
    fixture.sim.set_remote(port("sim"));
    fixture.fcu.write(fixture.from_fcu(mavlink::common::Heartbeat{}));
  }
  std::uint16_t port(const std::string& link) const { return casd.port(link); }
  /// Stops it; returns when no thread of it runs.
  bool stop() {
    casd.signal(SIGSTOP);
    const std::filesystem::path threads = "/proc/" + std::to_string(casd.pid()) + "/task";
    return wait_until([&] {
      for (const auto& thread : std::filesystem::directory_iterator(threads)) {
        // "1234 (casd:fcu) T ...": the name may hold anything.
        const std::string stat = TemporaryFolder::read(thread.path() / "stat");
        if (stat.substr(stat.rfind(')') + 1, 2) != " T") return false;
      }
      return true;
    });
  }
  void go_on() { casd.signal(SIGCONT); }

  CasdFixture fixture;
  RunningCasd casd;
};

TEST_P(CasdAge, NothingOldComesWhenCasdGoesOn) {
  CasdProgram casd(GetParam());
  UdpPeer station;
  station.set_remote(casd.port("gcs"));
  Controller controller(casd.fixture.fcu);
  Streams streams(casd.fixture.sim, station);
  ASSERT_TRUE(controller.read_until(
      [&] { return controller.count(kHilSensor) > 50 && controller.count(kManualControl) > 5; }));

  ASSERT_TRUE(casd.stop());
  const base::RunTime stopped = base::steady_now();
  ASSERT_TRUE(controller.read_for(kStall));
  casd.go_on();
  const base::RunTime goes_on = base::steady_now();
  ASSERT_TRUE(controller.read_until([&] {
    return newest_came(controller, streams, kHilSensor, goes_on) &&
           newest_came(controller, streams, kManualControl, goes_on);
  }));
  EXPECT_EQ(count_stale(controller, streams, kHilSensor, stopped), 0U);
  EXPECT_EQ(count_stale(controller, streams, kManualControl, stopped), 0U);
}

TEST_P(CasdAge, OfStickPositionsThatOneReadBringsTheNewestGoesOn) {
  // A busy machine lets none of them grow old.
  CasdProgram casd(GetParam(), ", queue: {setpoint_max_age_ms: 60000}");
  TcpPeer station(casd.port("tcp"));
  ASSERT_TRUE(station.connected());
  mav::Encoder from_station({255, 190});
  Controller controller(casd.fixture.fcu);
  station.send(from_station(stick(1)));
  ASSERT_TRUE(controller.read_until([&] {
    if (controller.count(kManualControl) == 0) station.send(from_station(stick(1)));
    return controller.count(kManualControl) > 0;
  }));
  controller.forget();

  ASSERT_TRUE(casd.stop());
  constexpr std::uint64_t kSticks = 100;
  std::vector<std::uint8_t> piled_up;
  for (std::uint64_t i = 2; i <= kSticks; ++i) {
    const auto packet = from_station(stick(i));
    piled_up.insert(piled_up.end(), packet.begin(), packet.end());
  }
  station.send(piled_up);
  casd.go_on();
  const auto count_from = [&](std::uint64_t number) {
    std::size_t n = 0;
    for (const Controller::Arrival& arrival : controller.arrivals()) {
      n += arrival.message == kManualControl && arrival.number >= number ? 1 : 0;
    }
    return n;
  };
  ASSERT_TRUE(controller.read_until([&] { return count_from(kSticks) == 1; }));
  EXPECT_EQ(count_from(2), 1U);
}

TEST_P(CasdAge, SaysThatALineStandsStillThatNobodyEverRead) {
  CasdProgram casd(GetParam());
  UdpPeer station;
  station.set_remote(casd.port("gcs"));
  Streams streams(casd.fixture.sim, station);
  const auto says = [&](const char* words) {
    return casd.casd.output().find(words) != std::string::npos;
  };
  ASSERT_TRUE(casd.casd.prints("link fcu: stands still")) << casd.casd.output();
  EXPECT_FALSE(says("moves again"));

  Controller controller(casd.fixture.fcu);
  const base::RunTime reads = base::steady_now();
  EXPECT_TRUE(controller.read_until([&] {
    return newest_came(controller, streams, kHilSensor, reads) && says("link fcu: moves again");
  })) << casd.casd.output();
}

INSTANTIATE_TEST_SUITE_P(Threads, CasdAge,
                         testing::Values("auto", "per_link", "single", "blocking"),
                         [](const auto& test) { return std::string(test.param); });

}  // namespace
}  // namespace cas::test
