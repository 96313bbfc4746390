// SPDX-License-Identifier: BSD-3-Clause
#include "tests/firmware/px4_hitl_fixture.hpp"

#include <poll.h>
#include <unistd.h>

#include <stdexcept>

#include "tests/support/free_port.hpp"
#include "tests/support/wait_until.hpp"

namespace cas::test {

Px4HitlFixture::Px4HitlFixture(const ScriptedPx4::Options& options, unsigned baud,
                               const Pilot::Plan& plan)
    : line_(folder_ / "fcu0"), boot_(base::steady_now()) {
  const std::uint16_t simulation_port = free_port();
  start_casd(baud, simulation_port);
  const auto to_line = [this](std::span<const std::uint8_t> bytes) { line_.write(bytes); };
  px4_ = std::make_unique<ScriptedPx4>(options, to_line, to_line);
  pilot_ =
      std::make_unique<Pilot>(plan, [this](std::span<const std::uint8_t> bytes,
                                           std::span<const casd::Path>) { ground_.send(bytes); });
  ground_.set_remote(port_of_link("gcs"));
  simulation_ = std::make_unique<RunningSimulation>(
      "px4_hitl.yaml", "mavlink_interface",
      "{local: '127.0.0.1:" + std::to_string(simulation_port) +
          "', remote: '127.0.0.1:" + std::to_string(port_of_link("sim")) + "'}",
      1.0);
}

void Px4HitlFixture::start_casd(unsigned baud, std::uint16_t simulation_port) {
  const std::string pace = baud > 0 ? ", baud: " + std::to_string(baud) : "";
  const std::string yaml = R"(schema: 1
links:
  - {name: sim, type: udp, local: "127.0.0.1:0", remote: "127.0.0.1:)" +
                           std::to_string(simulation_port) + R"("}
  - {name: fcu, type: serial, sensor_gap_ms: 3, device: ")" +
                           (folder_ / "fcu0").string() + "\"" + pace + R"(}
  - {name: gcs, type: udp, local: "127.0.0.1:0", remote: ")" +
                           ground_.endpoint() + R"("}
routes:
  - {from: sim, to: fcu, allow: [HEARTBEAT, HIL_SENSOR, HIL_GPS]}
  - {from: fcu, to: sim, allow: [HEARTBEAT, HIL_CONTROLS, HIL_ACTUATOR_CONTROLS]}
  - {from: fcu, to: gcs, block: [HIL_CONTROLS, HIL_ACTUATOR_CONTROLS]}
  - {from: gcs, to: fcu}
)";
  casd_ =
      std::make_unique<casd::LinkSet>(casd::Topology::parse(base::ConfigNode::parse(yaml, "test")));
  casd_->start();
  if (!wait_until([&] { return casd_->settled(); })) throw std::runtime_error("links hang");
}

std::uint16_t Px4HitlFixture::port_of_link(const std::string& name) const {
  for (const casd::LinkStatus& status : casd_->figures().links()) {
    if (status.name == name) return port_of(status.endpoint);
  }
  throw std::runtime_error("no link " + name);
}

void Px4HitlFixture::pump() {
  pollfd waiting{line_.master(), POLLIN, 0};
  ::poll(&waiting, 1, 1);
  std::array<std::uint8_t, 4096> bytes;
  const ssize_t size = ::read(line_.master(), bytes.data(), bytes.size());
  if (size > 0) {
    const std::uint64_t before = px4_->samples();
    const base::RunTime at = base::steady_now();
    px4_->on_ground_bytes(std::span(bytes).first(static_cast<std::size_t>(size)), now());
    arrivals_.insert(arrivals_.end(), px4_->samples() - before, at);
  }
  px4_->tick(now());
  PacketStream telemetry;
  ground_.read(telemetry);
  for (const auto& packet : telemetry.packets()) pilot_->on_bytes(packet.bytes, now());
  pilot_->tick(now());
}

}  // namespace cas::test
