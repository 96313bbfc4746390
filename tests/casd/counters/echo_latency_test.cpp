// SPDX-License-Identifier: BSD-3-Clause
#include "casd/counters/echo_latency.hpp"

#include <gtest/gtest.h>

#include <chrono>

#include "mavlink/common/hil_controls.hpp"
#include "mavlink/common/hil_sensor.hpp"
#include "mavlink_gen/runtime/encode.hpp"
#include "mavlink_gen/runtime/public_table.hpp"

namespace cas::casd::test {
namespace {

using std::chrono::microseconds;

base::RunTime at(base::Duration time) { return base::RunTime(time); }

/// A HIL_SENSOR, or the controls that answer it, with this stamp.
template <class Message>
void pass(EchoLatency& echo, std::uint8_t system, std::uint64_t stamp, base::Duration when) {
  Message message;
  message.time_usec = stamp;
  mav::Encoder encoder{{system, 1}};
  echo.on_packet(inspect(mav::view_packet(encoder(message)), mav::public_table()), at(when));
}

TEST(EchoLatency, TimesTwoHundredAndFiftyVehiclesWithTheSameStamps) {
  using mavlink::common::HilControls;
  using mavlink::common::HilSensor;
  EchoLatency echo;
  // All stamps of a second come before the first answer: no vehicle pushes out another one's.
  for (std::uint64_t stamp = 0; stamp < 500; ++stamp) {
    for (int system = 1; system <= 255; ++system) {
      pass<HilSensor>(echo, static_cast<std::uint8_t>(system), stamp, microseconds(stamp));
    }
  }
  for (int system = 1; system <= 255; ++system) {
    pass<HilControls>(echo, static_cast<std::uint8_t>(system), 499, microseconds(499 + 1000));
  }
  const auto figures = echo.figures();
  ASSERT_EQ(figures.size(), EchoLatency::kMaxVehicles);
  for (const EchoLatency::Figures& vehicle : figures) {
    EXPECT_EQ(vehicle.matched, 1U) << static_cast<int>(vehicle.system);
    EXPECT_EQ(vehicle.max, base::Duration(microseconds(1000)));
  }
}

TEST(EchoLatency, AStampThatNoSensorHadMatchesNothing) {
  EchoLatency echo;
  pass<mavlink::common::HilSensor>(echo, 1, 7, microseconds(0));
  pass<mavlink::common::HilControls>(echo, 1, 8, microseconds(1));
  pass<mavlink::common::HilControls>(echo, 2, 7, microseconds(1));
  const auto figures = echo.figures();
  ASSERT_EQ(figures.size(), 2U);
  EXPECT_EQ(figures[0].unmatched, 1U);
  EXPECT_EQ(figures[1].unmatched, 1U);
}

}  // namespace
}  // namespace cas::casd::test
