// SPDX-License-Identifier: BSD-3-Clause
// Files and missions of one vehicle for several ground stations at once: fcu_emulator on a
// pseudo-terminal, the real casd, two stations at a UDP server and one at a TCP server.
//
//   station 255/190 --+
//   station 252/190 --+-- gcs ---+
//   station 253/1 ------- tools -+-- casd -- fcu -- fcu_emulator
//   simulator 1/200 ----- sim ---+
#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <random>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "base/measure/ledger.hpp"
#include "mavlink/common/all.hpp"
#include "mavlink_gen/runtime/codec.hpp"
#include "mavlink_gen/runtime/public_table.hpp"
#include "mavlink_gen/services/address.hpp"
#include "mavlink_gen/services/ftp_exchange.hpp"
#include "mavlink_gen/services/mission_exchange.hpp"
#include "tests/loopback/tcp_peer.hpp"
#include "tests/support/child_process.hpp"
#include "tests/support/packet_stream.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/support/udp_peer.hpp"
#include "tests/support/wait_until.hpp"

namespace cas::test {
namespace {

using namespace mavlink::common;  // NOLINT
using mav::services::FtpExchange;
using mav::services::FtpResult;
using mav::services::MissionExchange;
using mav::services::Outcome;

constexpr mav::Source kVehicle{1, 1};
constexpr mav::Source kSimulator{1, 200};
constexpr std::size_t kFileBytes = 200'000;
constexpr std::size_t kShortBytes = 30'000;
constexpr std::uint16_t kItems = 200;

bool is_heartbeat_of_vehicle(const PacketStream::Packet& packet) {
  return packet.message_id == Heartbeat::kId && packet.source == kVehicle;
}

/// Target of a packet; 0 is broadcast.
mav::Source addressee(const mav::PacketView& packet) {
  const mav::MessageInfo& message = *mav::public_table().find(packet.message_id);
  const auto field = [&](int offset) {
    const auto at = static_cast<std::size_t>(offset);
    return offset < 0 || at >= packet.payload.size() ? std::uint8_t{0} : packet.payload[at];
  };
  return {field(message.target_system_offset), field(message.target_component_offset)};
}

/// A ground station that reads files and missions of 1/1.
class Station {
 public:
  /// Result of one transfer.
  template <class Result>
  struct Transfer {
    std::optional<Outcome> outcome;
    Result result;
    bool ended() const { return outcome.has_value(); }
    bool good() const { return outcome && outcome->ok(); }
    std::string text() const { return outcome ? outcome->message : "has not ended"; }
  };
  using Download = Transfer<FtpResult>;
  using Mission = Transfer<MissionExchange::Items>;

  Station(mav::Source self, std::shared_ptr<UdpPeer> peer, std::uint16_t first_number = 0)
      : Station(
            self, [peer](auto bytes) { peer->send(bytes); },
            [peer](PacketStream& into) { peer->read(into); }, first_number) {}
  Station(mav::Source self, std::shared_ptr<TcpPeer> peer)
      : Station(
            self, [peer](auto bytes) { peer->send(bytes); },
            [peer](PacketStream& into) { peer->read(into); }, 0) {}

  std::shared_ptr<Download> fetch(const std::string& path) {
    auto transfer = std::make_shared<Download>();
    ftp_.download(path, base::steady_now(), [transfer](const Outcome& outcome, const FtpResult& r) {
      *transfer = {outcome, r};
    });
    return transfer;
  }
  std::shared_ptr<Mission> upload(MissionExchange::Items items) {
    auto transfer = std::make_shared<Mission>();
    mission_.upload(std::move(items), base::steady_now(), keep(transfer));
    return transfer;
  }
  std::shared_ptr<Mission> download() {
    auto transfer = std::make_shared<Mission>();
    mission_.download(base::steady_now(), keep(transfer));
    return transfer;
  }

  void pump() {
    const base::RunTime now = base::steady_now();
    if (now >= next_beat_) {
      next_beat_ = now + std::chrono::milliseconds(500);
      send(Heartbeat{.type = MavType::kGcs, .autopilot = MavAutopilot::kInvalid});
    }
    read_(stream_);
    for (; !stream_.packets().empty(); stream_.packets().pop_front()) {
      const PacketStream::Packet& packet = stream_.packets().front();
      if (is_heartbeat_of_vehicle(packet)) hears_vehicle_ = true;
      const mav::Source to = addressee(packet.view());
      if (to.system != 0 && to != self_) ++others_;
      if (packet.message_id == MissionRequestInt::kId) was_asked_ = true;
      ftp_.on_packet(packet.view(), self_, now);
      mission_.on_packet(packet.view(), self_, now);
    }
    is_late_ = true;
    ftp_.tick(now);
    is_late_ = false;
    mission_.tick(now);
  }

  bool hears_vehicle() const { return hears_vehicle_; }
  /// The vehicle has asked it for an item.
  bool was_asked() const { return was_asked_; }
  /// Received packets that were addressed to others.
  int others() const { return others_; }
  /// Answers to file requests of another station with this one's ids, and late ones to requests
  /// that this one has repeated.
  std::uint64_t stray() const { return ftp_.oddities().stray; }
  /// File requests, repeated or for the missing rest, that it sent because a busy machine's answer
  /// was late.
  int repeats() const { return repeats_; }

 private:
  Station(mav::Source self, std::function<void(std::span<const std::uint8_t>)> write,
          std::function<void(PacketStream&)> read, std::uint16_t first_number)
      : self_(self),
        write_(std::move(write)),
        read_(std::move(read)),
        encoder_(self),
        ftp_(
            [this](const auto& m) {
              if (is_late_) ++repeats_;
              send(mav::services::addressed(m, kVehicle));
            },
            {}, first_number),
        mission_([this](const auto& any) {
          std::visit([this](const auto& m) { send(mav::services::addressed(m, kVehicle)); }, any);
        }) {}
  static MissionExchange::Done keep(const std::shared_ptr<Mission>& transfer) {
    return [transfer](const Outcome& outcome, const MissionExchange::Items& items) {
      *transfer = {outcome, items};
    };
  }
  template <class Message>
  void send(const Message& message) {
    write_(encoder_(message));
  }

  mav::Source self_;
  std::function<void(std::span<const std::uint8_t>)> write_;
  std::function<void(PacketStream&)> read_;
  PacketStream stream_;
  mav::Encoder encoder_;
  FtpExchange ftp_;
  MissionExchange mission_;
  base::RunTime next_beat_{};
  bool hears_vehicle_ = false;
  bool was_asked_ = false;
  int others_ = 0;
  bool is_late_ = false;  ///< while ftp_ repeats a request after its time-out
  int repeats_ = 0;
};

MissionExchange::Items mission(std::int32_t first_x) {
  MissionExchange::Items items(kItems);
  for (std::uint16_t i = 0; i < kItems; ++i) {
    items[i].seq = i;
    items[i].command = MavCmd::kNavWaypoint;
    items[i].frame = MavFrame::kGlobalRelativeAltInt;
    items[i].autocontinue = 1;
    items[i].x = first_x + 10 * i;
    items[i].y = 85'455'940 - i;
    items[i].z = 3.5F + static_cast<float>(i % 20);
  }
  return items;
}

/// The parts of items that a vehicle keeps.
std::vector<std::array<double, 4>> places(const MissionExchange::Items& items) {
  std::vector<std::array<double, 4>> all;
  for (const MissionItemInt& item : items) {
    all.push_back({static_cast<double>(item.seq), static_cast<double>(item.x),
                   static_cast<double>(item.y), static_cast<double>(item.z)});
  }
  return all;
}

/// The parameter is casd's `threads`.
class CasdServices : public testing::TestWithParam<const char*> {
 protected:
  CasdServices() {
    std::mt19937 random(7);
    for (char& byte : file_) byte = static_cast<char>(random());
    std::filesystem::create_directory(folder_ / "files");
    folder_.write("files/flight.bin", file_);
    folder_.write("files/short.bin", short_file_ = file_.substr(0, kShortBytes));
    const std::string device = (folder_ / "fcu0").string();
    const std::string controller =
        folder_.write("fcu.yaml", "schema: 1\nvehicle: " + source_dir() +
                                      "/config/vehicles/iris_paper.yaml\nline: {preset: ideal}\n");
    fcu_ = run({"fcu_emulator", controller, "--link", device, "--files",
                (folder_ / "files").string(), "--ledger", ledger_file().string()});
    // Nothing may grow old on a busy machine: a lost packet is a fault of the router's, then.
    const std::string topology = folder_.write(
        "casd.yaml",
        "schema: 1\nthreads: " + std::string(GetParam()) +
            "\ncommand_port: {port: 0, loopback_without_token: true}\n"
            "links:\n"
            "  - {name: sim, type: udp, local: '127.0.0.1:0', remote: '" +
            simulator_.endpoint() +
            "'}\n"
            "  - {name: fcu, type: serial, device: '" +
            device +
            "', baud: 0, queue: {hil_max_age_ms: 60000}}\n"
            "  - {name: gcs, type: udp_server, local: '127.0.0.1:0', accept: {traffic: "
            "ground_station}}\n"
            "  - {name: tools, type: tcp_server, local: '127.0.0.1:0', accept: {traffic: "
            "ground_station}}\n"
            "routes:\n"
            "  - {from: sim, to: fcu, allow: [HEARTBEAT, HIL_SENSOR]}\n"
            "  - {from: fcu, to: sim, allow: [HEARTBEAT, HIL_CONTROLS]}\n"
            "  - {from: fcu, to: [gcs, tools], block: [HIL_CONTROLS]}\n"
            "  - {from: [gcs, tools], to: fcu}\n");
    casd_ = run({"casd", topology});
    simulator_.set_remote(port("sim"));
  }

  std::unique_ptr<ChildProcess> run(std::vector<std::string> command) {
    command[0] = binary_dir() + "/bin/" + command[0];
    auto child = std::make_unique<ChildProcess>(command);
    const std::optional<std::string> ready = child->wait_ready();
    if (!ready) throw std::runtime_error(child->output());
    status_ = *ready;
    return child;
  }
  /// Where casd has bound a link.
  std::uint16_t port(const std::string& link) const { return port_of(word_after(status_, link)); }
  std::filesystem::path ledger_file() const { return folder_ / "ledger.csv"; }

  Station& add_udp(mav::Source self, std::uint16_t first_number = 0) {
    auto peer = std::make_shared<UdpPeer>();
    peer->set_remote(port("gcs"));
    return stations_.emplace_back(self, std::move(peer), first_number);
  }
  Station& add_tcp(mav::Source self) {
    return stations_.emplace_back(self, std::make_shared<TcpPeer>(port("tools")));
  }
  /// Three stations, each of which the vehicle's packets reach.
  void add_three() {
    add_udp({255, 190});
    add_udp({252, 190});
    add_tcp({253, 1});
    ASSERT_TRUE(meet());
  }
  bool meet() {
    return pump_until([this] {
      return std::ranges::all_of(stations_, [](const Station& s) { return s.hears_vehicle(); });
    });
  }

  /// Runs all nodes until the condition holds.
  bool pump_until(const std::function<bool()>& condition) {
    return wait_until(
        [&] {
          if (streams_) send_due_sensors();
          for (Station& station : stations_) station.pump();
          simulator_.read(at_simulator_);
          return condition();
        },
        std::chrono::seconds(60));
  }
  /// HIL_SENSOR at 500 Hz, numbered by its stamps: 2000, 4000, ... us.
  void send_due_sensors() {
    const base::RunTime now = base::steady_now();
    if (sensors_ == 0) next_sensor_ = now;
    for (; next_sensor_ <= now; next_sensor_ += std::chrono::milliseconds(2)) {
      HilSensor sensor;
      sensor.time_usec = 2000 * ++sensors_;
      sensor.zacc = -9.8F;
      sensor.xmag = 0.2F;
      sensor.zmag = 0.4F;
      sensor.abs_pressure = 955.0F;
      sensor.temperature = 15.0F;
      sensor.fields_updated = HilSensorUpdatedFlags{0x1FFF};
      simulator_.send(from_simulator_(sensor));
    }
  }
  /// The newest sensor sample that a HIL_CONTROLS answers.
  std::uint64_t answered_usec() {
    std::uint64_t newest = 0;
    for (const PacketStream::Packet& packet : at_simulator_.packets()) {
      const auto controls = mav::decode<HilControls>(packet.view());
      if (controls) newest = std::max(newest, controls->time_usec);
    }
    return newest;
  }

  std::vector<std::shared_ptr<Station::Download>> all_fetch(const std::string& file) {
    std::vector<std::shared_ptr<Station::Download>> downloads;
    for (Station& station : stations_) downloads.push_back(station.fetch("files/" + file));
    return downloads;
  }
  static void expect_whole(const std::vector<std::shared_ptr<Station::Download>>& downloads,
                           const std::string& file) {
    for (const auto& download : downloads) {
      ASSERT_TRUE(download->good()) << download->text();
      const auto& bytes = download->result.bytes;
      EXPECT_TRUE(std::string(bytes.begin(), bytes.end()) == file) << bytes.size();
      EXPECT_TRUE(download->result.checked);
    }
  }
  void expect_nobody_heard_others() {
    for (const Station& station : stations_) {
      EXPECT_EQ(station.others(), 0);
      if (station.repeats() == 0) {
        EXPECT_EQ(station.stray(), 0U);
      }
    }
  }

  TemporaryFolder folder_;
  std::string file_ = std::string(kFileBytes, '\0');
  std::string short_file_;
  std::unique_ptr<ChildProcess> fcu_;
  std::unique_ptr<ChildProcess> casd_;
  std::string status_;
  std::deque<Station> stations_;
  UdpPeer simulator_;
  mav::Encoder from_simulator_{kSimulator};
  PacketStream at_simulator_;
  bool streams_ = false;
  std::uint64_t sensors_ = 0;
  base::RunTime next_sensor_{};
};

template <class Transfers>
bool all_ended(const Transfers& transfers) {
  return std::ranges::all_of(transfers, [](const auto& each) { return each->ended(); });
}

TEST_P(CasdServices, ThreeStationsFetchOneFileAtOnce) {
  ASSERT_NO_FATAL_FAILURE(add_three());
  const auto downloads = all_fetch("flight.bin");
  ASSERT_TRUE(pump_until([&] { return all_ended(downloads); }));
  expect_whole(downloads, file_);
  expect_nobody_heard_others();
}

TEST_P(CasdServices, FetchingFilesCostsNoHilSensor) {
  ASSERT_NO_FATAL_FAILURE(add_three());
  streams_ = true;
  const auto downloads = all_fetch("flight.bin");
  ASSERT_TRUE(pump_until([&] { return all_ended(downloads); }));
  expect_whole(downloads, file_);
  const std::uint64_t counted = sensors_;
  ASSERT_TRUE(pump_until([&] { return answered_usec() > 2000 * counted; }));
  fcu_->signal(SIGTERM);
  ASSERT_EQ(fcu_->wait_exit(), 0) << fcu_->output();
  std::uint64_t arrived = 0;
  for (const base::LedgerEntry& entry : base::PacketLedger::read(ledger_file())) {
    const bool is_sensor = entry.direction == base::LedgerEntry::Direction::kReceived &&
                           entry.message_id == HilSensor::kId;
    if (!is_sensor || entry.time_usec > 2000 * counted) continue;
    EXPECT_EQ(entry.time_usec, 2000 * ++arrived) << "in order, each once";
  }
  EXPECT_EQ(arrived, counted);
  EXPECT_GT(counted, 50U) << "the stream ran beside the files";
}

TEST_P(CasdServices, AMissionGoesUpWhileTwoOthersComeDown) {
  ASSERT_NO_FATAL_FAILURE(add_three());
  const auto old_items = mission(473'000'000);
  const auto new_items = mission(474'000'000);
  const auto before = stations_[0].upload(old_items);
  ASSERT_TRUE(pump_until([&] { return before->ended(); }));
  ASSERT_TRUE(before->good()) << before->text();

  const auto up = stations_[0].upload(new_items);
  const std::vector down{stations_[1].download(), stations_[2].download()};
  ASSERT_TRUE(pump_until([&] { return up->ended() && all_ended(down); }));
  EXPECT_TRUE(up->good()) << up->text();
  for (const auto& each : down) {
    ASSERT_TRUE(each->good()) << each->text();
    EXPECT_EQ(places(each->result), places(old_items)) << "the mission as it was when asked for";
  }
  const std::vector after{stations_[0].download(), stations_[1].download(),
                          stations_[2].download()};
  ASSERT_TRUE(pump_until([&] { return all_ended(after); }));
  for (const auto& each : after) {
    ASSERT_TRUE(each->good()) << each->text();
    EXPECT_EQ(places(each->result), places(new_items));
  }
  expect_nobody_heard_others();
}

TEST_P(CasdServices, ASecondUploadIsDeniedUntilTheFirstHasEnded) {
  ASSERT_NO_FATAL_FAILURE(add_three());
  const auto first_items = mission(473'000'000);
  const auto second_items = mission(474'000'000);
  const auto first = stations_[0].upload(first_items);
  ASSERT_TRUE(pump_until([&] { return stations_[0].was_asked(); }));
  auto second = stations_[2].upload(second_items);
  ASSERT_TRUE(pump_until([&] { return second->ended(); }));
  EXPECT_EQ(second->outcome->kind, mav::services::OutcomeKind::kRefused);
  EXPECT_NE(second->text().find("denied"), std::string::npos) << second->text();
  ASSERT_TRUE(pump_until([&] { return first->ended(); }));
  EXPECT_TRUE(first->good()) << first->text();
  const auto down = stations_[1].download();
  ASSERT_TRUE(pump_until([&] { return down->ended(); }));
  EXPECT_EQ(places(down->result), places(first_items));

  second = stations_[2].upload(second_items);
  ASSERT_TRUE(pump_until([&] { return second->ended(); }));
  EXPECT_TRUE(second->good()) << second->text();
  expect_nobody_heard_others();
}

/// MAVLink cannot tell them apart: both get the packets for either, and each finds its own.
TEST_P(CasdServices, TwoStationsWithTheSameIdsBothReadFilesAndMissions) {
  Station& one = add_udp({255, 190}, 0);
  Station& other = add_udp({255, 190}, 30'000);
  ASSERT_TRUE(meet());
  const auto downloads = all_fetch("short.bin");
  ASSERT_TRUE(pump_until([&] { return all_ended(downloads); }));
  expect_whole(downloads, short_file_);
  EXPECT_GT(one.stray() + other.stray(), 0U) << "each heard the other's answers";

  const auto items = mission(473'000'000);
  const auto up = one.upload(items);
  ASSERT_TRUE(pump_until([&] { return up->ended(); }));
  ASSERT_TRUE(up->good()) << up->text();
  const std::vector down{one.download(), other.download()};
  ASSERT_TRUE(pump_until([&] { return all_ended(down); }));
  for (const auto& each : down) {
    ASSERT_TRUE(each->good()) << each->text();
    EXPECT_EQ(places(each->result), places(items));
  }
  EXPECT_EQ(one.others() + other.others(), 0);
}

/// Even requests with the same numbers: the vehicle's answer to one is an answer to both.
TEST_P(CasdServices, TwoStationsWithTheSameIdsAndRequestsBothGetTheFile) {
  add_udp({255, 190});
  add_udp({255, 190});
  ASSERT_TRUE(meet());
  const auto downloads = all_fetch("short.bin");
  ASSERT_TRUE(pump_until([&] { return all_ended(downloads); }));
  expect_whole(downloads, short_file_);
}

INSTANTIATE_TEST_SUITE_P(Threads, CasdServices, testing::Values("auto", "per_link", "single"),
                         [](const auto& test) { return std::string(test.param); });

}  // namespace
}  // namespace cas::test
