// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "base/error.hpp"
#include "tests/loopback/casd_bench.hpp"
#include "tests/support/no_more_descriptors.hpp"

namespace cas::test {
namespace {

std::string with_gcs(const std::string& extra) {
  std::string yaml = kHilTopology;
  yaml.insert(yaml.find("routes:"),
              "  - {name: gcs, type: udp_server, local: \"127.0.0.1:0\"" + extra + "}\n");
  return yaml + "  - {from: fcu, to: gcs}\n";
}

TEST(CasdReload, LosesNothingOfUnchangedLinksUnderLoad) {
  CasdBench bench;
  bench.start(kHilTopology);
  constexpr std::uint64_t kPackets = 2000;
  std::atomic<std::uint64_t> received{0};
  std::thread simulator([&] {
    // A few on their way at any time, so that the line is never more than it carries.
    for (std::uint64_t i = 1; i <= kPackets; ++i) {
      bench.sim.send(bench.from_sim(hil_sensor(i)));
      if (!wait_until([&] { return received + 5 > i; })) return;
    }
  });
  int reloads = 0;
  EXPECT_TRUE(wait_until([&] {
    bench.fcu.read(bench.at_fcu);
    received = bench.at_fcu.count(kHilSensor);
    if (received > static_cast<std::uint64_t>(reloads + 1) * 50) {
      const std::string yaml = ++reloads % 2 == 0 ? kHilTopology : with_gcs("");
      bench.links().reload(bench.parse(yaml));
    }
    return received == kPackets;
  }));
  simulator.join();
  EXPECT_GT(reloads, 20);
  EXPECT_EQ(bench.status("sim").reconnects, 0U);
  EXPECT_EQ(bench.status("fcu").reconnects, 0U);
  EXPECT_EQ(bench.status("sim").rx.packets, kPackets);
}

TEST(CasdReload, PutsNewRulesInForceAndReopensWhatChanged) {
  CasdBench bench;
  bench.start(with_gcs(""));
  const std::uint16_t before = bench.port("gcs");
  std::string yaml = with_gcs(", max_peers: 3");
  yaml.replace(yaml.find(", HIL_CONTROLS"), 14, "");
  bench.links().reload(bench.parse(yaml));
  ASSERT_TRUE(wait_until([&] { return bench.links().settled(); }));
  EXPECT_NE(bench.port("gcs"), before);  // another configuration, another socket

  bench.fcu.write(bench.from_fcu(hil_controls(1)));
  bench.fcu.write(bench.from_fcu(mavlink::common::Heartbeat{}));
  ASSERT_TRUE(bench.collect_until([&] { return bench.at_sim.count(kHeartbeat) == 1; }));
  EXPECT_EQ(bench.at_sim.count(kHilControls), 0U);
}

TEST(CasdReload, RefusesWhatOnlyARestartCanChange) {
  CasdBench bench;
  bench.start(kHilTopology);
  EXPECT_THROW(bench.links().reload(bench.parse(std::string("threads: single\n") + kHilTopology)),
               base::ConfigError);
  EXPECT_EQ(bench.links().topology().threads, casd::ThreadModel::kPerLink);
}

TEST(CasdReload, KeepsTheOldTopologyWhenANewLinkCannotBeMade) {
#ifdef __SANITIZE_ADDRESS__
  GTEST_SKIP() << "UndefinedBehaviorSanitizer opens a pipe to look at an object's type";
#endif
  CasdBench bench;
  bench.start(kHilTopology);
  const std::uint16_t before = bench.port("sim");
  // One link changes and several come: what the first would set free is not enough for the rest.
  std::string yaml = kHilTopology;
  const auto changed = yaml.find("60000");
  yaml.replace(changed, 5, "50000");
  for (const char* name : {"a", "b", "c", "d"}) {
    yaml.insert(yaml.find("routes:"), std::string("  - {name: ") + name +
                                          ", type: udp_server, local: \"127.0.0.1:0\"}\n");
  }
  const casd::Topology topology = bench.parse(yaml);
  {
    const NoMoreDescriptors limit;
    EXPECT_THROW(bench.links().reload(topology), base::ConfigError);
  }
  EXPECT_EQ(bench.links().topology().links.size(), 2U);
  EXPECT_EQ(bench.links().figures().links().size(), 2U);
  EXPECT_EQ(bench.port("sim"), before);
  bench.sim.send(bench.from_sim(hil_sensor(1)));
  bench.fcu.write(bench.from_fcu(hil_controls(1)));
  EXPECT_TRUE(bench.collect_until([&] {
    return bench.at_fcu.count(kHilSensor) == 1 && bench.at_sim.count(kHilControls) == 1;
  }));

  bench.links().reload(topology);  // now there is room
  EXPECT_EQ(bench.links().figures().links().size(), 6U);
  EXPECT_TRUE(wait_until([&] { return bench.links().settled(); }));
}

}  // namespace
}  // namespace cas::test
