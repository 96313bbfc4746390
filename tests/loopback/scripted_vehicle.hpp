// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <functional>
#include <thread>

#include "mavlink/common/table.hpp"
#include "mavlink_gen/runtime/packet_parser.hpp"
#include "tests/casd/fake_vehicle.hpp"
#include "tests/support/pty_pair.hpp"
#include "tests/support/wait_until.hpp"

namespace cas::test {

/// A scripted vehicle at the controller's end of a line (a PtyPair, or a class with the same reads
/// and writes), on a thread of its own: heartbeats ten times a second, answers by its script.
template <class Line>
class BasicScriptedVehicle {
 public:
  BasicScriptedVehicle(Line& line, std::function<void(casd::test::FakeVehicle&)> script)
      : line_(line), thread_([this, script = std::move(script)] {
          script(vehicle_);
          while (!stop_.load()) pump();
        }) {}
  ~BasicScriptedVehicle() { stop(); }

  /// Ends the thread. @return the vehicle, to look at
  casd::test::FakeVehicle& stop() {
    stop_ = true;
    if (thread_.joinable()) thread_.join();
    return vehicle_;
  }

 private:
  void pump() {
    const base::RunTime now = base::steady_now();
    if (now >= next_beat_) {
      vehicle_.say_heartbeat(now);
      next_beat_ = now + std::chrono::milliseconds(100);
    }
    line_.read(received_);
    for (const PacketStream::Packet& packet : received_.packets()) {
      vehicle_.handle(packet.view(), now);
    }
    received_.packets().clear();
    while (const auto packet = vehicle_.take(now)) line_.write(packet->view());
    ::poll(nullptr, 0, 1);
  }

  Line& line_;
  casd::test::FakeVehicle vehicle_;
  PacketStream received_;
  base::RunTime next_beat_{};
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

using ScriptedVehicle = BasicScriptedVehicle<PtyPair>;

}  // namespace cas::test
