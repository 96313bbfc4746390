// SPDX-License-Identifier: BSD-3-Clause
// The measurement over the emulator's line model, in virtual time: figures against the byte clock.
#include "hils/timing/line_probe.hpp"

#include <gtest/gtest.h>

#include <array>
#include <set>

#include "fcu/line/line_model.hpp"
#include "hils/timing/timing_verdict.hpp"
#include "mavlink/common/attitude.hpp"
#include "mavlink/common/heartbeat.hpp"
#include "mavlink_gen/runtime/codec.hpp"
#include "mavlink_gen/runtime/public_table.hpp"
#include "mavlink_gen/services/timesync.hpp"

namespace cas::hils {
namespace {

using namespace mavlink::common;  // NOLINT: the board's messages
using namespace std::chrono_literals;

/// Behaviour of a board.
struct Manner {
  bool beats = true;
  bool armed = false;
  bool answers_ping = true;
  bool answers_timesync = true;
};

/// A board at the end of a line.
class BoardOnALine {
 public:
  BoardOnALine(const fcu::LineConfig& config, Manner manner) : line(config, 1), manner_(manner) {}

  void turn(base::RunTime now) {
    std::array<std::uint8_t, 4096> buffer{};
    while (const std::size_t count = line.up(buffer, now)) {
      parser_.feed(std::span(buffer).first(count),
                   [&](const auto& packet) { answer(packet, now); });
    }
    for (; manner_.beats && now >= next; next += 20ms, ++beats_) {
      if (beats_ % 50 == 0) line.send(encode_(heartbeat()), now);
      line.send(encode_(Attitude{.time_boot_ms = 1, .yawspeed = 1}), now);
    }
  }

  fcu::EmulatorLine line;
  base::RunTime next{};
  std::set<std::uint32_t> heard;

 private:
  Heartbeat heartbeat() const {
    Heartbeat message{.autopilot = MavAutopilot::kPx4, .base_mode = MavModeFlag::kHilEnabled};
    if (manner_.armed) message.base_mode = message.base_mode | MavModeFlag::kSafetyArmed;
    return message;
  }
  void answer(const mav::PacketView& packet, base::RunTime now) {
    heard.insert(packet.message_id);
    if (const auto ping = mav::decode<Ping>(packet); ping && manner_.answers_ping) {
      if (const auto reply = mav::services::answer(*ping, packet.source)) {
        line.send(encode_(*reply), now);
      }
    }
    if (const auto sync = mav::decode<Timesync>(packet); sync && manner_.answers_timesync) {
      if (const auto reply = mav::services::answer(*sync, packet.source, 1s)) {
        line.send(encode_(*reply), now);
      }
    }
  }

  Manner manner_;
  mav::PacketParser parser_{mav::public_table()};
  mav::Encoder encode_{{1, 1}};
  int beats_ = 0;
};

struct Measured {
  LineFigures figures;
  std::set<std::uint32_t> sent;
  base::RunTime end{};
};

Measured measure(const fcu::LineConfig& config, Manner manner = {}, LineDemand demand = {}) {
  BoardOnALine board(config, manner);
  base::RunTime now{};
  LineProbe probe({.demand = demand, .length = 1500ms, .seed = 3}, now);
  std::array<std::uint8_t, 4096> buffer{};
  while (!probe.done() && now < base::RunTime(120s)) {
    probe.turn(now);
    const std::size_t room = std::min(board.line.up_room(now), probe.unsent().size());
    board.line.receive(probe.unsent().first(room), now);
    probe.sent(room);
    base::RunTime next = std::min(probe.wake(), board.next);
    if (!manner.beats) next = probe.wake();
    if (const auto event = board.line.next_event(now)) next = std::min(next, *event);
    now = std::max(next, now + 1us);
    board.turn(now);
    while (const std::size_t count = board.line.down(buffer, now)) {
      probe.take(std::span(buffer).first(count), now);
    }
  }
  EXPECT_TRUE(probe.done());
  return {probe.figures(), board.heard, now};
}

fcu::LineConfig uart(double baud) {
  fcu::LineConfig config = fcu::LineConfig::from_preset("baud_921600");
  config.baud = baud;
  return config;
}

/// The pieces of a throughput end with whole packets: 254 bytes of some 1700 at 57600 baud, in the
/// middle of five pieces. A round trip may meet a packet of telemetry.
constexpr double kShare = 0.05;

TEST(LineProbeOnUart, FindsWhatTheByteClockLetsThrough) {
  struct BaudCase {
    const char* name;
    double baud;
    bool fits;
    double fitting_hz;  // of HIL_SENSOR
  };
  const BaudCase rows[] = {{"At57600", 57'600, false, 50},
                           {"At115200", 115'200, false, 125},
                           {"At460800", 460'800, true, 0},
                           {"At921600", 921'600, true, 0}};
  for (const auto& test : rows) {
    SCOPED_TRACE(test.name);
    const LineFigures figures = measure(uart(test.baud)).figures;
    const double bytes_s = test.baud / 10;
    EXPECT_EQ(figures.end, ProbeEnd::kWhole);
    EXPECT_TRUE(figures.in_hil);
    EXPECT_NEAR(figures.to_bytes_s, bytes_s, kShare * bytes_s);
    EXPECT_NEAR(figures.from_bytes_s, bytes_s, kShare * bytes_s);
    // PING has 24 bytes there and 26 back, TIMESYNC 28 and 30 or less.
    EXPECT_NEAR(figures.ping.least_ms, 1e3 * 50 / bytes_s, kShare * 1e3 * 50 / bytes_s);
    EXPECT_GT(figures.timesync.least_ms, figures.ping.least_ms);
    EXPECT_EQ(figures.ping.lost(), 0U);
    EXPECT_EQ(figures.frame, std::nullopt);
    const TimingVerdict verdict = judge_line(figures, {});
    EXPECT_EQ(verdict.code, test.fits ? kExitPassed : kExitLimitsMissed) << verdict.sentence;
    EXPECT_EQ(verdict.fitting_sensor_hz.value_or(0), test.fitting_hz) << verdict.sentence;
  }
}

TEST(LineProbe, SendsNothingThatAnAutopilotActsOn) {
  constexpr std::uint32_t kV2Extension = 248;
  EXPECT_EQ(measure(uart(921'600)).sent,
            (std::set<std::uint32_t>{Heartbeat::kId, Ping::kId, Timesync::kId, kV2Extension}));
}

TEST(LineProbe, LeavesAnArmedVehicleAlone) {
  const Measured armed = measure(uart(921'600), {.armed = true});
  EXPECT_EQ(armed.figures.end, ProbeEnd::kArmed);
  for (const std::uint32_t id : armed.sent) EXPECT_EQ(id, Heartbeat::kId);
}

TEST(LineProbe, GivesUpOnASilentLineAfterTenSeconds) {
  const Measured silent = measure(uart(921'600), {.beats = false});
  EXPECT_EQ(silent.figures.end, ProbeEnd::kSilent);
  EXPECT_NEAR(base::to_seconds(silent.end), 10, 0.1);
}

TEST(LineProbe, AsksByWhatTheBoardAnswers) {
  const LineFigures figures = measure(uart(921'600), {.answers_ping = false}).figures;
  EXPECT_EQ(figures.end, ProbeEnd::kWhole);
  EXPECT_EQ(figures.asked, QuestionKind::kTimesync);
  EXPECT_EQ(figures.ping.answered, 0U);
  EXPECT_EQ(judge_line(figures, {}).code, kExitPassed);
  const Manner mute{.answers_ping = false, .answers_timesync = false};
  EXPECT_EQ(measure(uart(921'600), mute).figures.end, ProbeEnd::kNoAnswers);
}

TEST(LineProbe, SeesTheFramesOfUsb) {
  EXPECT_EQ(measure(fcu::LineConfig::from_preset("usb")).figures.frame, 1ms);
}

TEST(LineProbe, FailsALineThatLosesPackets) {
  fcu::LineConfig config = uart(921'600);
  config.packet_loss = 0.02;
  const LineFigures figures = measure(config).figures;
  EXPECT_GT(figures.loads.front().echoes.lost(), 0U);
  const TimingVerdict verdict = judge_line(figures, {});
  EXPECT_EQ(verdict.code, kExitLimitsMissed);
  EXPECT_NE(verdict.sentence.find("questions had no answer"), std::string::npos)
      << verdict.sentence;
}

TEST(LineProbe, OffersTheBytesOfTheStreamThatIsWanted) {
  const LineFigures figures = measure(uart(921'600)).figures;
  ASSERT_GE(figures.loads.size(), 4U);
  const LoadFigures& wanted = figures.loads[3];
  EXPECT_EQ(wanted.sensor_hz, 500);
  EXPECT_NEAR(wanted.to_bytes_s, 500 * 77 + 5 * 51, 150);
  // 400 answers of two PINGs, and telemetry.
  EXPECT_NEAR(wanted.from_bytes_s, 400 * 52 + figures.background_bytes_s, 500);
  EXPECT_LT(wanted.own_lateness_ms, 0.01);
}

}  // namespace
}  // namespace cas::hils
