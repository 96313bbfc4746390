// SPDX-License-Identifier: BSD-3-Clause
// A fleet over real sockets: the load of `fleet_load`, paced so that any machine carries it.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <string>
#include <vector>

#include "base/rpc/client.hpp"
#include "tests/bench/fleet.hpp"
#include "tests/loopback/running_casd.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/support/wait_until.hpp"

namespace cas::test {
namespace {

/// The parameter is the number of kinds of messages.
class CasdFleet : public testing::TestWithParam<int> {};

TEST_P(CasdFleet, OfAHundredVehiclesLosesNoPacketOnTheWayToFourStations) {
  constexpr FleetLoad kLoad{.vehicles = 100, .stations = 4, .hz = 20, .seconds = 2.5};
  FleetLoad load = kLoad;
  load.kinds = GetParam();
  ASSERT_EQ(load.packets(), 50);
  const TemporaryFolder folder;
  Fleet fleet(load);
  // Nothing may grow old on a busy machine.
  const std::string topology = fleet.topology(0, ", queue: {telemetry_max_age_ms: 60000}");
  RunningCasd casd({kCasdProgram, folder.write("fleet.yaml", topology)});
  base::rpc::Client client(casd.address());
  ASSERT_TRUE(wait_until([&] { return fleet.meet(client); }));

  const std::vector<std::size_t> none(4, 0);
  wait_until(
      [&] {
        const bool all_sent = fleet.send_due(base::steady_now());
        fleet.read(base::steady_now());
        return all_sent && fleet.missing() == none;
      },
      std::chrono::seconds(60));
  EXPECT_EQ(fleet.missing(), none);
  EXPECT_EQ(fleet.repeated(), 0U);
}

INSTANTIATE_TEST_SUITE_P(Kinds, CasdFleet, testing::Values(1, FleetLoad::kMostKinds),
                         [](const auto& test) { return "Of" + std::to_string(test.param); });

}  // namespace
}  // namespace cas::test
