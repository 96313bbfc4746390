// SPDX-License-Identifier: BSD-3-Clause
// UBX by its published bytes, and the plugin as an autopilot sees it: over its pseudo-terminal.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <cstring>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "base/earth/frames.hpp"
#include "base/os/descriptor.hpp"
#include "plugins/ubx/ubx_frame.hpp"
#include "plugins/ubx/ubx_messages.hpp"
#include "plugins/ubx/ubx_receiver.hpp"
#include "tests/plugins/plugin_harness.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/support/wait_until.hpp"

namespace cas::sim {
namespace {

using std::chrono::milliseconds;
using Bytes = std::vector<std::uint8_t>;

// Frames as u-blox and its users print them.
const Bytes kMonVerPoll{0xB5, 0x62, 0x0A, 0x04, 0x00, 0x00, 0x0E, 0x34};
const Bytes kRate5Hz{0xB5, 0x62, 0x06, 0x08, 0x06, 0x00, 0xC8,
                     0x00, 0x01, 0x00, 0x01, 0x00, 0xDE, 0x6A};
const Bytes kPvtOn{0xB5, 0x62, 0x06, 0x01, 0x03, 0x00, 0x01, 0x07, 0x01, 0x13, 0x51};
const Bytes kAckOfCfgMsg{0xB5, 0x62, 0x05, 0x01, 0x02, 0x00, 0x06, 0x01, 0x0F, 0x38};

Bytes framed(UbxId id, const Bytes& payload) {
  Bytes out;
  append_ubx(out, id, payload);
  return out;
}

template <class T>
T value_at(const Bytes& payload, std::size_t at) {
  T value;
  std::memcpy(&value, payload.data() + at, sizeof value);
  return value;
}

TEST(UbxFrame, HasThePublishedBytes) {
  EXPECT_EQ(framed(ubx::kMonVer, {}), kMonVerPoll);
  EXPECT_EQ(framed(ubx::kCfgRate, {0xC8, 0, 1, 0, 1, 0}), kRate5Hz);
  EXPECT_EQ(framed(ubx::kCfgMsg, {0x01, 0x07, 0x01}), kPvtOn);
  EXPECT_EQ(framed(ubx::kAckAck, {0x06, 0x01}), kAckOfCfgMsg);
}

TEST(UbxParser, FindsFramesBetweenGarbageAndWrongSums) {
  Bytes stream{'$', 'G', 0xB5, 0xB5};
  Bytes wrong = kPvtOn;
  wrong[8] = 0x02;
  for (const Bytes& part : {kRate5Hz, wrong, kMonVerPoll}) {
    stream.insert(stream.end(), part.begin(), part.end());
  }
  UbxParser parser;
  std::vector<std::pair<UbxId, std::size_t>> found;
  for (const std::uint8_t byte : stream) {
    parser.feed({&byte, 1},
                [&](UbxId id, auto payload) { found.emplace_back(id, payload.size()); });
  }
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(found[0], std::pair(ubx::kCfgRate, std::size_t{6}));
  EXPECT_EQ(found[1], std::pair(ubx::kMonVer, std::size_t{0}));
  EXPECT_EQ(parser.counts().frames, 2U);
  EXPECT_EQ(parser.counts().bad_checksums, 1U);
  EXPECT_GE(parser.counts().garbage_bytes, 4U);
}

UbxEpoch one_epoch() {
  UbxEpoch epoch;
  // 12 July 2026 06:30:15.25 UTC: week 2427, Sunday.
  const std::uint64_t tow_ms = (6 * 3600 + 30 * 60 + 15 + 18) * 1000ULL + 250;
  epoch.gps_ns = (2427 * 604'800'000ULL + tow_ms) * 1'000'000;
  epoch.fix.satellites = 10;
  epoch.fix.position = {47.397742, -8.545594, 488.25};
  epoch.fix.velocity_N = {3, -4, 0.5};
  epoch.fix.eph_m = 0.5;
  epoch.fix.epv_m = 0.8;
  return epoch;
}

TEST(UbxMessages, NavPvtSaysTimePlaceAndVelocity) {
  const Bytes pvt = nav_pvt(one_epoch());
  ASSERT_EQ(pvt.size(), 92U);
  EXPECT_EQ(value_at<std::uint32_t>(pvt, 0), 23'433'250U);
  EXPECT_EQ(value_at<std::uint16_t>(pvt, 4), 2026);
  EXPECT_EQ(Bytes(pvt.begin() + 6, pvt.begin() + 11), (Bytes{7, 12, 6, 30, 15}));
  EXPECT_EQ(value_at<std::int32_t>(pvt, 16), 250'000'000);
  EXPECT_EQ(pvt[20], 3);
  EXPECT_EQ(pvt[21], 1);
  EXPECT_EQ(pvt[23], 10);
  EXPECT_EQ(value_at<std::int32_t>(pvt, 24), -85'455'940);
  EXPECT_EQ(value_at<std::int32_t>(pvt, 28), 473'977'420);
  EXPECT_EQ(value_at<std::int32_t>(pvt, 36), 488'250);
  EXPECT_EQ(value_at<std::uint32_t>(pvt, 40), 500U);
  EXPECT_EQ(value_at<std::int32_t>(pvt, 48), 3000);
  EXPECT_EQ(value_at<std::int32_t>(pvt, 52), -4000);
  EXPECT_EQ(value_at<std::int32_t>(pvt, 56), 500);
  EXPECT_EQ(value_at<std::int32_t>(pvt, 60), 5000);
  EXPECT_EQ(value_at<std::int32_t>(pvt, 64), 30'686'990) << "course";
  EXPECT_EQ(value_at<std::uint16_t>(pvt, 76), 100);

  UbxEpoch lost = one_epoch();
  lost.fix.fix_type = 1;
  const Bytes none = nav_pvt(lost);
  EXPECT_EQ(none[20], 0);
  EXPECT_EQ(none[21], 0);
  EXPECT_EQ(value_at<std::int32_t>(none, 28), 0);
}

TEST(UbxMessages, SatellitesShowTheJammer) {
  UbxEpoch epoch = one_epoch();
  const Bytes clear = nav_sat(epoch);
  ASSERT_EQ(clear.size(), 8U + 12 * 10);
  EXPECT_EQ(clear[5], 10);
  EXPECT_EQ(clear[8 + 2], 49) << "the strongest, of 44 dB-Hz on the mean";
  EXPECT_EQ(clear[8 + 12 * 9 + 2], 39);
  EXPECT_EQ(mon_rf(epoch)[5], 1);
  epoch.fix.cn0_db_hz = 24;
  epoch.fix.satellites = 4;
  EXPECT_EQ(nav_sat(epoch)[8 + 2], 29);
  EXPECT_EQ(mon_rf(epoch)[5], 3) << "critical";
  EXPECT_EQ(mon_rf(epoch)[20], 170);
  EXPECT_EQ(value_at<std::uint16_t>(nav_dop(epoch), 6), 158);
}

TEST(UbxMessages, TwoAntennasGiveAHeading) {
  UbxEpoch epoch = one_epoch();
  epoch.baseline_N = Eigen::Vector3d(0, -1.23456, 0.5);
  const Bytes relative = nav_rel_pos_ned(epoch);
  ASSERT_EQ(relative.size(), 64U);
  EXPECT_EQ(value_at<std::int32_t>(relative, 12), -123);
  EXPECT_EQ(value_at<std::int8_t>(relative, 33), -46);
  EXPECT_EQ(value_at<std::int32_t>(relative, 16), 50);
  EXPECT_EQ(value_at<std::int32_t>(relative, 20), 133);
  EXPECT_EQ(value_at<std::int32_t>(relative, 24), 27'000'000);
  EXPECT_EQ(value_at<std::uint32_t>(relative, 60) & 0x104U, 0x104U);
}

/// CFG-VALSET of keys with values of one byte, or four where the key says so.
Bytes valset(const std::vector<std::pair<std::uint32_t, std::uint32_t>>& pairs) {
  Bytes payload{0, 1, 0, 0};
  for (const auto& [key, value] : pairs) {
    for (int i = 0; i < 4; ++i) payload.push_back(static_cast<std::uint8_t>(key >> (8 * i)));
    const int size = (key >> 28) == 4 ? 4 : (key >> 28) == 3 ? 2 : 1;
    for (int i = 0; i < size; ++i) payload.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
  }
  return framed(ubx::kCfgValSet, payload);
}

constexpr std::uint32_t kKeyBaud = 0x40520001;
constexpr std::uint32_t kKeyRate = 0x30210001;
constexpr std::uint32_t kKeyPvt = 0x20910007;
constexpr std::uint32_t kKeySat = 0x20910016;

TEST(UbxReceiver, AcknowledgesWhatItIsToldAndAnswersPolls) {
  UbxReceiver receiver(115'200);
  base::SimTime now;
  const auto said = [&](const Bytes& bytes) {
    receiver.receive(bytes);
    receiver.next(now);
    now += milliseconds(100);
    const auto answer = receiver.next(now);
    const Bytes copy(answer.begin(), answer.end());
    now += milliseconds(1);
    receiver.next(now);
    return copy;
  };
  const auto acked = [](UbxId id) { return framed(ubx::kAckAck, {id.group, id.id}); };
  EXPECT_EQ(said(kPvtOn), kAckOfCfgMsg);
  EXPECT_TRUE(receiver.configured());
  EXPECT_EQ(said(kRate5Hz), acked(ubx::kCfgRate));
  EXPECT_EQ(receiver.wanted_period_ms(), 200U);
  EXPECT_EQ(said(valset({{kKeyBaud, 230'400}, {kKeyRate, 100}, {kKeySat, 2}})),
            acked(ubx::kCfgValSet));
  EXPECT_EQ(receiver.baud(), 230'400U);
  EXPECT_EQ(receiver.wanted_period_ms(), 100U);
  Bytes torn{0, 1, 0, 0, 0x01, 0x00, 0x52, 0x40, 0x00};
  EXPECT_EQ(said(framed(ubx::kCfgValSet, torn)), framed(ubx::kAckNak, {0x06, 0x8A}));

  Bytes told = framed(ubx::kCfgValGet, {1, 0, 0, 0, 0x16, 0x00, 0x91, 0x20, 2});
  const Bytes ack = acked(ubx::kCfgValGet);
  told.insert(told.end(), ack.begin(), ack.end());
  EXPECT_EQ(said(framed(ubx::kCfgValGet, {0, 0, 0, 0, 0x16, 0x00, 0x91, 0x20})), told);

  // A driver reads back what it has set: a rate that is sent, one that is not, and other settings.
  const auto polled = [&](UbxId id, const Bytes& which, const Bytes& answer) {
    Bytes told_first = framed(id, answer);
    const Bytes end = acked(id);
    told_first.insert(told_first.end(), end.begin(), end.end());
    EXPECT_EQ(said(framed(id, which)), told_first);
  };
  polled(ubx::kCfgMsg, {0x01, 0x07}, {0x01, 0x07, 0, 1, 0, 0, 0, 0});
  said(framed(ubx::kCfgMsg, {0x0A, 0x09, 0x05}));
  polled(ubx::kCfgMsg, {0x0A, 0x09}, {0x0A, 0x09, 0, 5, 0, 0, 0, 0});
  polled(ubx::kCfgRate, {}, {0xC8, 0, 1, 0, 1, 0});
  polled({0x06, 0x24}, {}, Bytes(36));

  const Bytes version = said(kMonVerPoll);
  const std::string text(version.begin(), version.end());
  EXPECT_NE(text.find("PROTVER=27.31"), std::string::npos);
  EXPECT_NE(text.find("00190000"), std::string::npos);
  const Bytes port = said(framed(ubx::kCfgPrt, {1}));
  EXPECT_EQ(value_at<std::uint32_t>(port, 6 + 8), 230'400U);
}

/// 9600 baud carry 960 bytes a second: of 1000 that are asked for, whole epochs are left out.
TEST(UbxReceiver, SendsAtTheRateOfItsLineAndDropsWholeEpochs) {
  UbxReceiver receiver(9'600);
  receiver.receive(kPvtOn);
  base::SimTime now;
  std::size_t bytes = 0;
  std::size_t frames = 0;
  UbxParser driver;
  for (int ms = 0; ms < 10'000; ++ms) {
    if (ms % 100 == 0) receiver.on_epoch(one_epoch());  // 100 bytes each
    now += milliseconds(1);
    const auto sent = receiver.next(now);
    bytes += sent.size();
    driver.feed(sent, [&](UbxId id, auto) { frames += id == ubx::kNavPvt ? 1 : 0; });
  }
  EXPECT_LE(bytes, 9'600U);
  EXPECT_GT(frames, 45U);
  EXPECT_EQ(driver.counts().garbage_bytes, 0U);
  EXPECT_EQ(receiver.counts().epochs + receiver.counts().dropped, 100U);
  EXPECT_GT(receiver.counts().dropped, 0U);
}

TEST(UbxPlugin, GivesFixesToADriverAtTheOtherEndOfItsLine) {
  const test::TemporaryFolder folder;
  const std::string link = (folder.path() / "gps").string();
  test::PluginHarness harness;
  harness.world.body.q_WB = base::q_WB_from_q_ND(base::quaternion_rpy(0, 0, M_PI / 2));
  harness.add("gps",
              "{rate_hz: 10, position_stddev_m: 0.1, velocity_stddev_m_s: 0.05, eph_m: 0.9, "
              "epv_m: 1.2, satellites: 12}");
  const Plugin& plugin =
      harness.add("ubx", "{pty: " + link + ", baud: 115200, baseline_B_m: [1, 0, 0]}");
  const base::Descriptor line(::open(link.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC));
  ASSERT_TRUE(line);
  const Bytes orders = valset({{kKeyPvt, 1}, {kKeySat, 1}, {0x2091008E, 1}});
  ASSERT_EQ(::write(line.get(), orders.data(), orders.size()), static_cast<ssize_t>(orders.size()));
  const auto figures = [&plugin] { return nlohmann::json::parse(plugin.stats_json()); };
  ASSERT_TRUE(test::wait_until([&] {
    harness.step();
    return figures()["configured"].get<bool>();
  }));
  UbxParser driver;
  std::map<std::uint8_t, std::size_t> seen;  // by id
  Bytes relative;
  const auto read = [&] {
    std::array<std::uint8_t, 512> buffer;
    const ssize_t size = ::read(line.get(), buffer.data(), buffer.size());
    if (size <= 0) return;
    driver.feed(std::span(buffer).first(static_cast<std::size_t>(size)),
                [&](UbxId id, auto payload) {
                  ++seen[id.id];
                  if (id == ubx::kNavRelPosNed) relative.assign(payload.begin(), payload.end());
                });
  };
  for (int ms = 0; ms < 2000; ++ms) {
    harness.step();
    read();
  }
  const std::size_t epochs = figures()["epochs"];
  EXPECT_GE(epochs, 20U);
  ASSERT_TRUE(test::wait_until([&] {
    read();
    return seen[ubx::kNavSat.id] + 1 >= epochs;  // the last may be under way
  }));
  EXPECT_GE(seen[ubx::kNavPvt.id] + 1, epochs);
  EXPECT_EQ(driver.counts().bad_checksums + driver.counts().garbage_bytes, 0U);
  EXPECT_EQ(value_at<std::int32_t>(relative, 24), 9'000'000) << "the nose looks east";
  EXPECT_EQ(figures()["dropped"], 0);
}

}  // namespace
}  // namespace cas::sim
