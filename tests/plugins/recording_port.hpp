// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>
#include <string>
#include <vector>

#include "mavlink/common/all.hpp"
#include "mavlink_gen/runtime/codec.hpp"
#include "mavlink_gen/runtime/packet_parser.hpp"
#include "plugins/mavlink_interface/hil_conversion.hpp"
#include "plugins/mavlink_interface/hil_port.hpp"

namespace cas::test {

namespace mv = mavlink::common;
using std::chrono::milliseconds;

/// Keeps sent packets decoded; delivers packets from the test.
class RecordingPort final : public sim::HilPort {
 public:
  bool send(std::span<const std::uint8_t> packet) override {
    if (refuses) return false;
    packets.emplace_back(packet.begin(), packet.end());
    parser.feed(packet, [this](const mav::PacketView& view) {
      ids.push_back(view.message_id);
      source = view.source;
      if (const auto sensor = mav::decode<mv::HilSensor>(view)) sensors.push_back(*sensor);
      if (const auto gps = mav::decode<mv::HilGps>(view)) fixes.push_back(*gps);
    });
    return true;
  }
  void poll(const OnBytes& on_bytes) override {
    for (const auto& bytes : in) on_bytes(bytes, clock);
    in.clear();
  }
  bool wait(base::Duration) override { return !in.empty(); }
  base::RunTime now() const override { return clock; }
  std::string endpoint() const override { return "test"; }

  template <class Message>
  void put(const Message& message) {
    const auto bytes = encoder(message);
    in.emplace_back(bytes.begin(), bytes.end());
  }

  mav::PacketParser parser{mv::table()};
  mav::Encoder encoder{{1, 1}};
  std::vector<std::uint32_t> ids;
  std::vector<std::vector<std::uint8_t>> packets;  ///< as bytes
  std::vector<mv::HilSensor> sensors;
  std::vector<mv::HilGps> fixes;
  mav::Source source;
  std::deque<std::vector<std::uint8_t>> in;
  base::RunTime clock{std::chrono::seconds(100)};
  bool refuses = false;
};

inline base::SimTime at_ms(int ms) { return base::SimTime(milliseconds(ms)); }

inline mv::HilControls controls_for(int ms, float throttle = 0.5F) {
  mv::HilControls controls{.time_usec = static_cast<std::uint64_t>(ms) * 1000,
                           .throttle = throttle};
  controls.mode = static_cast<decltype(controls.mode)>(128 + 32);
  return controls;
}

inline std::uint32_t updated(const mv::HilSensor& packet) {
  return static_cast<std::uint32_t>(packet.fields_updated);
}

}  // namespace cas::test
