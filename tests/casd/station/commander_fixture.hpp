// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <optional>
#include <type_traits>

#include "casd/station/vehicle_commander.hpp"
#include "mavlink/common/table.hpp"
#include "mavlink_gen/runtime/packet_parser.hpp"
#include "tests/casd/fake_vehicle.hpp"

namespace cas::casd::test {

inline constexpr LinkId kLink = 2;

/// A commander and one vehicle on a virtual clock.
class VehicleCommanderTest : public testing::Test {
 protected:
  explicit VehicleCommanderTest(CommanderOptions options = {.ask_on_sight = false})
      : commander_(options, [this](std::span<const std::uint8_t> bytes, std::span<const Path>) {
          parser_.feed(bytes,
                       [this](const mav::PacketView& packet) { vehicle_.handle(packet, now_); });
        }) {}

  /// Lets the vehicle be heard.
  void meet() {
    vehicle_.say_heartbeat(now_);
    run_for(std::chrono::milliseconds(50));
  }

  void run_for(base::Duration time) {
    for (const base::RunTime end = now_ + time; now_ < end; now_ += std::chrono::milliseconds(5))
      step();
  }
  /// Runs until the request has ended. @return its outcome
  Outcome finish() {
    for (const base::RunTime end = now_ + std::chrono::seconds(60); !outcome_ && now_ < end;
         now_ += std::chrono::milliseconds(5))
      step();
    EXPECT_TRUE(outcome_.has_value()) << "the request never ended";
    return outcome_.value_or(Outcome{});
  }
  Done done() {
    outcome_.reset();
    return [this](const Outcome& outcome) {
      EXPECT_FALSE(outcome_.has_value()) << "a request ended twice";
      outcome_ = outcome;
    };
  }
  /// Asks the commander of vehicle 1, and runs until the request has ended.
  template <class Verb, class... Args>
  Outcome ask(Verb verb, Args... args) {
    if constexpr (std::is_invocable_v<Verb, VehicleCommander&, int, Args..., base::RunTime, Done>) {
      (commander_.*verb)(1, args..., now_, done());
    } else {
      (commander_.*verb)(1, args..., now_, done(), false);  // without consent
    }
    return finish();
  }
  Outcome arm(VehicleCommander::ArmOptions options = {}) {
    return ask(&VehicleCommander::arm, options);
  }
  /// Lets the vehicle say a message, and the commander hear it.
  template <class Message>
  void say(const Message& message) {
    vehicle_.say(message, now_);
    run_for(std::chrono::milliseconds(50));
  }

  base::RunTime now_{std::chrono::seconds(1)};
  FakeVehicle vehicle_;
  mav::PacketParser parser_{mavlink::common::table()};
  VehicleCommander commander_;
  std::optional<Outcome> outcome_;

 private:
  void step() {
    while (const auto packet = vehicle_.take(now_)) {
      mav::PacketParser parser(mavlink::common::table());
      parser.feed(packet->view(),
                  [this](const mav::PacketView& view) { commander_.on_packet(kLink, view, now_); });
    }
    if (now_ - last_beat_ >= std::chrono::seconds(1)) {
      if (last_beat_ != base::RunTime{} && beating_) vehicle_.say_heartbeat(now_);
      last_beat_ = now_;
    }
    if (now_.time_since_epoch() % std::chrono::milliseconds(50) == std::chrono::milliseconds(0))
      commander_.tick(now_);
  }
  base::RunTime last_beat_{};

 protected:
  bool beating_ = true;
};

}  // namespace cas::casd::test
