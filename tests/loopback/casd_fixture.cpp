// SPDX-License-Identifier: BSD-3-Clause
#include "tests/loopback/casd_fixture.hpp"

#include <stdexcept>

namespace cas::test {

const char* const kHilTopology = R"(schema: 1
links:
  - {name: sim, type: udp, local: "127.0.0.1:0", remote: "$SIM", queue: {hil_max_age_ms: 60000}}
  - {name: fcu, type: serial, device: "$FCU", baud: 921600, queue: {hil_max_age_ms: 60000}}
routes:
  - {from: sim, to: fcu, allow: [HEARTBEAT, HIL_SENSOR, HIL_GPS]}
  - {from: fcu, to: sim, allow: [HEARTBEAT, HIL_CONTROLS]}
)";

mavlink::common::HilSensor hil_sensor(std::uint64_t number) {
  return {.time_usec = number, .zacc = -9.8F, .temperature = 20.0F};
}

mavlink::common::HilControls hil_controls(std::uint64_t number) {
  return {.time_usec = number, .throttle = 0.5F};
}

mavlink::common::HilGps hil_gps(std::uint64_t number) {
  return {.time_usec = number, .satellites_visible = 10};
}

std::vector<std::uint64_t> numbers(const PacketStream& stream, std::uint32_t message_id) {
  std::vector<std::uint64_t> found;
  for (const PacketStream::Packet& packet : const_cast<PacketStream&>(stream).packets()) {
    if (packet.message_id != message_id) continue;
    std::uint64_t number = 0;  // time_usec is the first field of the HIL messages
    const auto payload = packet.view().payload;
    for (std::size_t i = 0; i < 8 && i < payload.size(); ++i) {
      number |= std::uint64_t{payload[i]} << 8 * i;
    }
    found.push_back(number);
  }
  return found;
}

CasdFixture::CasdFixture() : fcu(folder / "fcu0") {}

void CasdFixture::start(const std::string& yaml, casd::RetryTimes retry) {
  links_ = std::make_unique<casd::LinkSet>(parse(yaml), retry);
  links_->start();
  if (!wait_until([&] { return links_->settled(); })) throw std::runtime_error("links hang");
  for (const auto& link : links_->figures().links()) {
    if (link.name == "sim" && link.state == casd::LinkState::kUp) sim.set_remote(port("sim"));
  }
}

std::string CasdFixture::expand(std::string yaml) const {
  const auto replace = [&](const std::string& word, const std::string& by) {
    for (std::size_t at = yaml.find(word); at != std::string::npos; at = yaml.find(word)) {
      yaml.replace(at, word.size(), by);
    }
  };
  replace("$SIM", sim.endpoint());
  replace("$FCU", (folder / "fcu0").string());
  replace("$DIR", folder.path().string());
  return yaml;
}

casd::Topology CasdFixture::parse(const std::string& yaml) const {
  return casd::Topology::parse(base::ConfigNode::parse(expand(yaml)));
}

casd::LinkStatus CasdFixture::status(const std::string& link) const {
  for (const casd::LinkStatus& status : links_->figures().links()) {
    if (status.name == link) return status;
  }
  throw std::runtime_error("no link " + link);
}

std::uint16_t CasdFixture::port(const std::string& link) const {
  return port_of(status(link).endpoint);
}

void CasdFixture::collect() {
  sim.read(at_sim);
  fcu.read(at_fcu);
}

}  // namespace cas::test
