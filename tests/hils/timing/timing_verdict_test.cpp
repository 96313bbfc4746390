// SPDX-License-Identifier: BSD-3-Clause
#include "hils/timing/timing_verdict.hpp"

#include <gtest/gtest.h>

namespace cas::hils {
namespace {

constexpr double kWide = 1e6;  // bytes/s: USB

LoadFigures kept(double sensor_hz) {
  return {.sensor_hz = sensor_hz,
          .echoes = {.asked = 600, .answered = 600, .least_ms = 1, .median_ms = 1.5},
          .late_median_ms = 1.5};
}

LineFigures line(double to_bytes_s, double from_bytes_s) {
  return {.in_hil = true,
          .background_bytes_s = 1000,
          .to_bytes_s = to_bytes_s,
          .from_bytes_s = from_bytes_s,
          .loads = {kept(250), kept(500), kept(750)}};
}

TEST(TimingVerdict, SaysHowMuchIsToSpare) {
  // HIL_SENSOR 500 x 77, HIL_GPS 5 x 51 and HEARTBEAT 21 bytes are 38776 of 98 % of 57343.
  const TimingVerdict verdict = judge_line(line(57'343, kWide), {});
  EXPECT_EQ(verdict.code, kExitPassed);
  EXPECT_NEAR(verdict.spare, 0.31, 1e-4);
  EXPECT_EQ(verdict.sentence,
            "500 Hz HIL_SENSOR (plus 5 Hz HIL_GPS, 400 Hz answers) fits with 31 % to spare");
  EXPECT_TRUE(verdict.notes.empty());
}

TEST(TimingVerdict, OfAPseudoTerminalSaysWhatAUartWouldSpare) {
  const LineFigures fast = line(52e6, 52e6);
  EXPECT_EQ(uart_note(fast, {}, 921'600),
            "a pseudo-terminal has no baud rate: its throughput is that of the program behind it; "
            "a UART of 921600 baud carries 92.2 kB/s, and would have 57 % to spare");
  const std::string slow = uart_note(fast, {}, 115'200);
  EXPECT_TRUE(
      slow.ends_with("a UART of 115200 baud carries 11.5 kB/s, and would not carry that: "
                     "to the controller it takes 38.8 kB/s of 11.3"))
      << slow;
}

TEST(TimingVerdict, IsOfTheFullerDirection) {
  // HIL_CONTROLS 400 x 54 and 1000 bytes of telemetry are 22600.
  const TimingVerdict verdict = judge_line(line(kWide, 46'122), {});
  EXPECT_EQ(verdict.code, kExitPassed);
  EXPECT_NEAR(verdict.spare, 0.5, 1e-3);
}

TEST(TimingVerdict, NamesTheDirectionThatIsTooNarrowAndTheRateThatFits) {
  LineFigures figures = line(11'520, 11'520);
  figures.loads = {LoadFigures{.sensor_hz = 125, .overloaded = true}};
  figures.slower = {kept(125)};
  const TimingVerdict verdict = judge_line(figures, {});
  EXPECT_EQ(verdict.code, kExitLimitsMissed);
  EXPECT_EQ(verdict.fitting_sensor_hz, 125);
  EXPECT_EQ(verdict.sentence,
            "500 Hz HIL_SENSOR (plus 5 Hz HIL_GPS, 400 Hz answers) does not fit: to the controller "
            "it takes 38.8 kB/s of 11.3; 125 Hz fits; 460800 baud would carry it");
}

TEST(TimingVerdict, OfALineThatLosesSaysWhatWasLost) {
  LineFigures figures = line(92'160, 92'160);
  figures.loads[1].echoes.answered = 540;
  figures.slower = {LoadFigures{.sensor_hz = 50, .echoes = {.asked = 60, .answered = 50}}};
  const TimingVerdict verdict = judge_line(figures, {});
  EXPECT_EQ(verdict.code, kExitLimitsMissed);
  EXPECT_FALSE(verdict.fitting_sensor_hz);
  EXPECT_NE(
      verdict.sentence.find("at 500 Hz 60 of 600 questions had no answer; no usual rate fits"),
      std::string::npos)
      << verdict.sentence;
}

TEST(TimingVerdict, IsNotSpoiledByATooHighRate) {
  LineFigures figures = line(92'160, 92'160);
  figures.loads.back().overloaded = true;
  EXPECT_EQ(judge_line(figures, {}).code, kExitPassed);
}

TEST(TimingVerdict, IsNoneWhereThisMachineWasTooLate) {
  LineFigures figures = line(92'160, 92'160);
  figures.loads[1].overloaded = true;
  figures.loads[1].own_lateness_ms = 30;
  const TimingVerdict verdict = judge_line(figures, {});
  EXPECT_EQ(verdict.code, kExitInvalid);
  EXPECT_EQ(verdict.sentence, "no verdict: this machine was too busy to send the load in time");
}

TEST(TimingVerdict, TellsOfALongSilence) {
  LineFigures figures = line(92'160, 92'160);
  figures.loads[1].longest_gap_ms = 62;
  figures.in_hil = false;
  const TimingVerdict verdict = judge_line(figures, {});
  EXPECT_EQ(verdict.code, kExitPassed);
  ASSERT_EQ(verdict.notes.size(), 2U);
  EXPECT_NE(verdict.notes[0].find("not say that it is in HIL"), std::string::npos);
  EXPECT_NE(verdict.notes[1].find("for 62 ms nothing came"), std::string::npos);
}

TEST(TimingVerdict, CountsTheLongerAnswersOfStockFirmware) {
  // HIL_ACTUATOR_CONTROLS has 93 bytes: 200 a second are 18600, HIL_CONTROLS would be 10800.
  const LineDemand stock{.sensor_hz = 250, .controls_hz = 200, .by_rotor = true};
  EXPECT_EQ(budget_from(stock, 0, kWide).load_bytes_s(), 18'600);
}

}  // namespace
}  // namespace cas::hils
