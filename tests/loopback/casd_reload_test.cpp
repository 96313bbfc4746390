// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "base/error.hpp"
#include "tests/loopback/casd_fixture.hpp"
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
  CasdFixture fixture(kHilTopology);
  constexpr std::uint64_t kPackets = 2000;
  std::atomic<std::uint64_t> received{0};
  std::thread simulator([&] {
    // A few on their way at any time, so that the line is never more than it carries.
    for (std::uint64_t i = 1; i <= kPackets; ++i) {
      fixture.sim.send(fixture.from_sim(hil_sensor(i)));
      if (!wait_until([&] { return received + 5 > i; })) return;
    }
  });
  int reloads = 0;
  EXPECT_TRUE(wait_until([&] {
    fixture.fcu.read(fixture.at_fcu);
    received = fixture.at_fcu.count(kHilSensor);
    if (received > static_cast<std::uint64_t>(reloads + 1) * 50) {
      const std::string yaml = ++reloads % 2 == 0 ? kHilTopology : with_gcs("");
      fixture.links().reload(fixture.parse(yaml));
    }
    return received == kPackets;
  }));
  simulator.join();
  EXPECT_GT(reloads, 20);
  EXPECT_EQ(fixture.status("sim").reconnects, 0U);
  EXPECT_EQ(fixture.status("fcu").reconnects, 0U);
  EXPECT_EQ(fixture.status("sim").rx.packets, kPackets);
}

TEST(CasdReload, PutsNewRulesInForceAndReopensWhatChanged) {
  CasdFixture fixture(with_gcs(""));
  const std::uint16_t before = fixture.port("gcs");
  std::string yaml = with_gcs(", max_peers: 3");
  yaml.replace(yaml.find(", HIL_CONTROLS"), 14, "");
  fixture.links().reload(fixture.parse(yaml));
  ASSERT_TRUE(wait_until([&] { return fixture.links().settled(); }));
  EXPECT_NE(fixture.port("gcs"), before);  // another configuration, another socket

  fixture.fcu.write(fixture.from_fcu(hil_controls(1)));
  fixture.fcu.write(fixture.from_fcu(mavlink::common::Heartbeat{}));
  ASSERT_TRUE(fixture.collect_until([&] { return fixture.at_sim.count(kHeartbeat) == 1; }));
  EXPECT_EQ(fixture.at_sim.count(kHilControls), 0U);
}

TEST(CasdReload, RefusesWhatOnlyARestartCanChange) {
  CasdFixture fixture(kHilTopology);
  EXPECT_THROW(
      fixture.links().reload(fixture.parse(std::string("threads: single\n") + kHilTopology)),
      base::ConfigError);
  EXPECT_EQ(fixture.links().topology().threads, casd::ThreadModel::kAuto);
}

TEST(CasdReload, KeepsTheOldTopologyWhenANewLinkCannotBeMade) {
#ifdef __SANITIZE_ADDRESS__
  GTEST_SKIP() << "UndefinedBehaviorSanitizer opens a pipe to look at an object's type";
#endif
  CasdFixture fixture;
  const std::string threads = "threads: per_link\n";  // a thread takes descriptors
  fixture.start(threads + kHilTopology);
  const std::uint16_t before = fixture.port("sim");
  // One link changes and several come: the descriptors that the first would free are not enough for
  // the others.
  std::string yaml = threads + kHilTopology;
  const auto changed = yaml.find("60000");
  yaml.replace(changed, 5, "50000");
  for (const char* name : {"a", "b", "c", "d"}) {
    yaml.insert(yaml.find("routes:"), std::string("  - {name: ") + name +
                                          ", type: udp_server, local: \"127.0.0.1:0\"}\n");
  }
  const casd::Topology topology = fixture.parse(yaml);
  {
    const NoMoreDescriptors limit;
    EXPECT_THROW(fixture.links().reload(topology), base::ConfigError);
  }
  EXPECT_EQ(fixture.links().topology().links.size(), 2U);
  EXPECT_EQ(fixture.links().figures().links().size(), 2U);
  EXPECT_EQ(fixture.port("sim"), before);
  fixture.sim.send(fixture.from_sim(hil_sensor(1)));
  fixture.fcu.write(fixture.from_fcu(hil_controls(1)));
  EXPECT_TRUE(fixture.collect_until([&] {
    return fixture.at_fcu.count(kHilSensor) == 1 && fixture.at_sim.count(kHilControls) == 1;
  }));

  fixture.links().reload(topology);  // now there is room
  EXPECT_EQ(fixture.links().figures().links().size(), 6U);
  EXPECT_TRUE(wait_until([&] { return fixture.links().settled(); }));
}

}  // namespace
}  // namespace cas::test
