// SPDX-License-Identifier: BSD-3-Clause
#include "hils/timing/line_demand.hpp"

#include <algorithm>
#include <array>

#include "casd/queue/line_timing.hpp"
#include "mavlink/common/heartbeat.hpp"
#include "mavlink/common/hil_actuator_controls.hpp"
#include "mavlink/common/hil_controls.hpp"
#include "mavlink/common/hil_gps.hpp"
#include "mavlink/common/hil_sensor.hpp"
#include "mavlink_gen/runtime/packet.hpp"

namespace cas::hils {

namespace {

using namespace mavlink::common;  // NOLINT: sizes of its messages

constexpr std::array kUsualRates{500.0, 400.0, 250.0, 200.0, 125.0, 100.0, 50.0};

template <class Message>
constexpr std::size_t packet_bytes() {
  return mav::kHeaderBytesV2 + Message::kMaxLength + mav::kChecksumBytes;
}

casd::LineLoad load(std::uint32_t id, double hz, std::size_t bytes) {
  return {.message_id = id, .hz = hz, .packet_bytes = static_cast<double>(bytes)};
}

}  // namespace

std::size_t sensor_bytes() { return packet_bytes<HilSensor>(); }
std::size_t gps_bytes() { return packet_bytes<HilGps>(); }
std::size_t controls_bytes(const LineDemand& demand) {
  return demand.by_rotor ? packet_bytes<HilActuatorControls>() : packet_bytes<HilControls>();
}

LineDemand at_sensor_rate(LineDemand demand, double sensor_hz) {
  demand.sensor_hz = sensor_hz;
  demand.controls_hz = std::min(demand.controls_hz, sensor_hz);
  return demand;
}

std::span<const double> usual_sensor_rates() { return kUsualRates; }

casd::LineBudget budget_to(const LineDemand& demand, double bytes_s) {
  return {.link = "to the controller",
          .capacity_bytes_s = casd::LinePacer::kLineShare * bytes_s,
          .loads = {load(Heartbeat::kId, 1, packet_bytes<Heartbeat>()),
                    load(HilSensor::kId, demand.sensor_hz, sensor_bytes()),
                    load(HilGps::kId, demand.gps_hz, gps_bytes())}};
}

casd::LineBudget budget_from(const LineDemand& demand, double background_bytes_s, double bytes_s) {
  return {.link = "from the controller",
          .capacity_bytes_s = casd::LinePacer::kLineShare * bytes_s,
          .loads = {load(demand.by_rotor ? HilActuatorControls::kId : HilControls::kId,
                         demand.controls_hz, controls_bytes(demand)),
                    {.message_id = Heartbeat::kId, .hz = 1, .packet_bytes = background_bytes_s}}};
}

}  // namespace cas::hils
