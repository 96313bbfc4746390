// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "base/error.hpp"
#include "casd/topology/topology.hpp"
#include "tests/casd/key_changes.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/temporary_folder.hpp"

// Each key that casd reads, taken from the lists that it reads them by.

namespace cas::casd::test {
namespace {

using cas::test::KeyChange;
using cas::test::TemporaryFolder;

class TopologyKeys : public testing::Test {
 protected:
  TopologyKeys() {
    for (const char* key : {"a.key", "b.key"}) folder_.write(key, "schema: 1\n");
  }
  Topology parse(std::string yaml) const {
    const std::string word = "$DIR";
    for (std::size_t at = yaml.find(word); at != yaml.npos; at = yaml.find(word)) {
      yaml.replace(at, word.size(), folder_.path().string());
    }
    return Topology::parse(base::ConfigNode::parse("schema: 1\n" + yaml));
  }
  Topology with_lines(const std::string& lines) const {
    return parse(lines + "links: [{name: x, type: udp, local: '127.0.0.1:0'}]\n");
  }
  Topology with_link(const std::string& link) const { return parse("links: [" + link + "]\n"); }

  TemporaryFolder folder_;
};

TEST_F(TopologyKeys, AreAllSeenByAReload) {
  std::size_t seen = 0;
  for (int i = 0; i <= static_cast<int>(LinkType::kTlog); ++i) {
    const auto type = static_cast<LinkType>(i);
    for (const KeyChange& change : cas::test::link_changes(type)) {
      const Topology before = with_link(change.before);
      bool differs = false;
      for (const std::string& after : change.after) {
        if (!after.empty()) differs |= with_link(after).links[0] != before.links[0];
      }
      EXPECT_TRUE(differs) << "a reload does not see another " << change.key
                           << " of a link of type " << to_string(type);
      ++seen;
    }
  }
  EXPECT_GT(seen, 100U);
}

TEST_F(TopologyKeys, TakeARestartOrAreInForce) {
  const auto changed = [&](const KeyChange& change) -> std::optional<std::vector<std::string>> {
    const Topology before = with_lines(change.before);
    for (const std::string& text : change.after) {
      if (text.empty()) continue;
      const Topology after = with_lines(text);
      if (after != before) return restart_keys(before, after);
    }
    return std::nullopt;
  };
  for (const KeyChange& change : cas::test::topology_changes(restart_rows())) {
    const auto keys = changed(change);
    ASSERT_TRUE(keys) << change.key;
    EXPECT_EQ(*keys, std::vector{change.key.substr(0, change.key.find('.'))});
  }
  for (const KeyChange& change : cas::test::topology_changes(reload_rows())) {
    const auto keys = changed(change);
    ASSERT_TRUE(keys) << change.key;
    EXPECT_TRUE(keys->empty()) << change.key << ": " << keys->front();
  }
}

// A bound that a sentence refuses is one that the reference tells.
TEST_F(TopologyKeys, AreRefusedOutsideOfTheirBounds) {
  EXPECT_THROW(with_lines("system_id: 0\n"), base::ConfigError);
  EXPECT_THROW(with_lines("cpu_dma_latency_us: 10001\n"), base::ConfigError);
  EXPECT_THROW(with_link("{name: x, type: udp, local: 'h:1', queue: {hil_max_age_ms: 0.05}}"),
               base::ConfigError);
}

// A removed key is not reported as a misspelt one.
TEST_F(TopologyKeys, ThatAreGoneAreNamedWithWhatHoldsWithoutThem) {
  const auto expect = [](const std::string& refusal, const std::string& sentence) {
    EXPECT_NE(refusal.find(sentence), std::string::npos) << refusal;
  };
  const std::string link = "{name: x, type: udp, local: '127.0.0.1:0', queue: {gps_kib: 8}}";
  expect(cas::test::refusal([&] { with_lines("lock_memory: true\n"); }),
         "lock_memory: is no longer a key: memory is locked where");
  expect(cas::test::refusal([&] { with_lines("route_lifetime_s: 60\n"); }),
         "route_lifetime_s: is no longer a key: a system is no target");
  expect(cas::test::refusal([&] { with_link(link); }),
         "links[0].queue.gps_kib: is no longer a key");
  for (const std::string key : {"max_mib", "max_files", "free_space_min_mib"}) {
    expect(cas::test::refusal([&] { with_lines("log: {" + key + ": 1}\n"); }),
           "log." + key + ": is no longer a key: write it in `log: {keep: {...}}`");
    expect(cas::test::refusal([&] { with_lines("log: {autopilot: {" + key + ": 1}}\n"); }),
           "log.autopilot." + key + ": is no longer a key: write it in `log: {keep: {...}}`");
  }
  expect(cas::test::refusal([&] { with_lines("log: {delete_oldest: true}\n"); }),
         "log.delete_oldest: is no longer a key: with `log: {keep: {...}}` the oldest");
  expect(cas::test::refusal([&] { with_lines("log: {autopilot: {delete_oldest: true}}\n"); }),
         "log.autopilot.delete_oldest: is no longer a key: with `log: {keep: {...}}`");
  expect(cas::test::refusal([&] { with_lines("log: {rotate_minutes: 1}\n"); }),
         "log.rotate_minutes: is no longer a key: files of a recording are divided by size");
  expect(cas::test::refusal([&] { with_lines("log: {autopilot: {folder: a}}\n"); }),
         "log.autopilot.folder: is no longer a key: all logs go to the `folder` of `log`");
}

// Without the block casd deletes nothing.
TEST_F(TopologyKeys, OfTheBlockKeepLetCasdDeleteOldLogs) {
  EXPECT_FALSE(with_lines("log: {tlog: a}\n").log.keep.delete_oldest);
  EXPECT_TRUE(with_lines("log: {keep: {}}\n").log.keep.delete_oldest);
  EXPECT_EQ(with_lines("log: {keep: {}}\n").log.keep.max_bytes, std::nullopt);
  EXPECT_EQ(with_lines("log: {keep: {max_mib: 0}}\n").log.keep.max_bytes, 0U);
}

TEST_F(TopologyKeys, OfAPriorityMeanRealTime) {
  EXPECT_FALSE(with_lines("").runs_in_real_time());
  EXPECT_TRUE(with_lines("scheduling: {fifo_priority: 20}\n").runs_in_real_time());
  EXPECT_TRUE(
      with_link("{name: x, type: udp, local: '127.0.0.1:0', scheduling: {fifo_priority: 1}}")
          .runs_in_real_time());
}

}  // namespace
}  // namespace cas::casd::test
