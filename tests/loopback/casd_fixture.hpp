// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>

#include "casd/link_set.hpp"
#include "mavlink/common/all.hpp"
#include "tests/support/packet_stream.hpp"
#include "tests/support/pty_pair.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/support/udp_peer.hpp"
#include "tests/support/wait_until.hpp"

namespace cas::test {

inline constexpr std::uint32_t kHeartbeat = mavlink::common::Heartbeat::kId;
inline constexpr std::uint32_t kHilSensor = mavlink::common::HilSensor::kId;
inline constexpr std::uint32_t kHilGps = mavlink::common::HilGps::kId;
inline constexpr std::uint32_t kHilControls = mavlink::common::HilControls::kId;

/// A HIL_SENSOR that carries its number.
mavlink::common::HilSensor hil_sensor(std::uint64_t number);
mavlink::common::HilControls hil_controls(std::uint64_t number);
mavlink::common::HilGps hil_gps(std::uint64_t number);
/// The numbers of the packets of one message, in the order of their arrival.
std::vector<std::uint64_t> numbers(const PacketStream& stream, std::uint32_t message_id);

/// casd's links in this process between a simulator's socket and a controller's line.
class CasdFixture {
 public:
  CasdFixture();
  /// Starts with this topology.
  explicit CasdFixture(const std::string& yaml, casd::RetryTimes retry = {}) : CasdFixture() {
    start(yaml, retry);
  }

  /// Starts with this topology. "$SIM", "$FCU" and "$DIR" stand for the simulator's address, the
  /// controller's device and a temporary folder.
  void start(const std::string& yaml, casd::RetryTimes retry = {});
  std::string expand(std::string yaml) const;
  casd::Topology parse(const std::string& yaml) const;

  casd::LinkSet& links() { return *links_; }
  casd::LinkStatus status(const std::string& link) const;
  /// Where a link is bound, as a port.
  std::uint16_t port(const std::string& link) const;
  /// Reads both ends.
  void collect();
  /// Reads both ends until the condition holds.
  template <class Condition>
  bool collect_until(Condition&& condition) {
    return wait_until([&] {
      collect();
      return condition();
    });
  }

  TemporaryFolder folder;
  UdpPeer sim;
  PtyPair fcu;
  PacketStream at_sim;
  PacketStream at_fcu;
  mav::Encoder from_sim{{1, 200}};
  mav::Encoder from_fcu{{1, 1}};

 private:
  std::unique_ptr<casd::LinkSet> links_;
};

/// sim <-> fcu with the HIL streams alone; on a loaded machine nothing is dropped by age.
extern const char* const kHilTopology;

}  // namespace cas::test
