// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "casd/station/gain_map.hpp"
#include "casd/topology/injection.hpp"
#include "casd/topology/topology.hpp"
#include "tests/support/paths.hpp"

namespace cas::casd {
namespace {

bool has_serial_link(const Topology& topology) {
  return std::any_of(topology.links.begin(), topology.links.end(),
                     [](const LinkConfig& link) { return link.type == LinkType::kSerial; });
}

TEST(ShippedTopologies, AreReadAndNameTheShippedGains) {
  int count = 0;
  for (const auto& entry :
       std::filesystem::directory_iterator(cas::test::source_dir() + "/config/topologies")) {
    const Topology topology = Topology::load(entry.path());
    EXPECT_FALSE(topology.links.empty()) << entry.path();
    // Only where no wire leads to motors.
    EXPECT_FALSE(topology.commanding.allow_not_hil && has_serial_link(topology)) << entry.path();
    for (const std::string& warning : injection_warnings(topology)) {
      ADD_FAILURE() << entry.path() << ": " << warning;
    }
    EXPECT_FALSE(GainMap::load(topology.gains).empty()) << entry.path();
    ++count;
  }
  EXPECT_GE(count, 5);
}

}  // namespace
}  // namespace cas::casd
