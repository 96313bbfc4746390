// SPDX-License-Identifier: BSD-3-Clause
#include "base/config/config.hpp"

#include <gtest/gtest.h>

#include <Eigen/Core>

#include "tests/support/temporary_folder.hpp"

namespace cas::base {
namespace {

TEST(Config, ReadsEachTypeOfValue) {
  const ConfigNode node = ConfigNode::parse(R"(
flag: true
count: -3
size: 7
big: 18446744073709551615
rate_hz: 2.5e2
name: imu
word: off
digits: 042
numbers: [1, 2.5, +3]
words: [a, "b c"]
p_m: [1, 2, 3]
q: [1, 0, 0, 0]
)");
  EXPECT_TRUE(node.require<bool>("flag"));
  EXPECT_EQ(node.require<int>("count"), -3);
  EXPECT_EQ(node.require<unsigned>("size"), 7U);
  EXPECT_EQ(node.require<std::uint64_t>("big"), 18446744073709551615U);
  EXPECT_EQ(node.require<double>("rate_hz"), 250.0);
  EXPECT_EQ(node.require<std::string>("name"), "imu");
  EXPECT_EQ(node.require<std::string>("word"), "off");
  EXPECT_EQ(node.require<std::string>("digits"), "042");
  EXPECT_EQ(node.require<std::vector<double>>("numbers"), (std::vector<double>{1, 2.5, 3}));
  EXPECT_EQ(node.require<std::vector<std::string>>("words"),
            (std::vector<std::string>{"a", "b c"}));
  EXPECT_EQ(node.require<Eigen::Vector3d>("p_m"), Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(node.require<Eigen::Vector4d>("q"), Eigen::Vector4d(1, 0, 0, 0));
  EXPECT_NO_THROW(node.reject_unused());
}

TEST(Config, AMissingOptionalKeyTakesTheFallback) {
  const ConfigNode node = ConfigNode::parse("a: 1");
  EXPECT_EQ(node.get("b", 5), 5);
  EXPECT_EQ(node.get("a", 5), 1);
  EXPECT_EQ(node.get_in("b", 0.5, 0, 1), 0.5);
  EXPECT_FALSE(node.has("b"));
  EXPECT_FALSE(node.find("b").has_value());
}

TEST(Config, AnEmptyNodeReadsLikeAMapWithoutKeys) {
  for (const ConfigNode& node :
       {ConfigNode::empty(), ConfigNode::parse(""), ConfigNode::parse("block:").at("block")}) {
    EXPECT_EQ(node.get("rate_hz", 4.0), 4.0);
    EXPECT_TRUE(node.entries().empty());
    EXPECT_NO_THROW(node.reject_unused());
  }
}

TEST(Config, KnowsWhereEachNodeStands) {
  const ConfigNode node =
      ConfigNode::parse("links:\n  - name: sim\n  - name: fcu\n    device: x\n");
  const std::vector<ConfigNode> links = node.at("links").items();
  ASSERT_EQ(links.size(), 2U);
  EXPECT_EQ(links[1].at("device").path(), "links[1].device");
  EXPECT_EQ(links[1].at("device").line(), 4);
  EXPECT_EQ(node.at("links").line(), 1);
}

TEST(Config, KeepsTheOrderOfEntries) {
  const ConfigNode node = ConfigNode::parse("z: 1\na: 2\nm: 3");
  std::string order;
  for (const auto& [key, child] : node.entries()) order += key;
  EXPECT_EQ(order, "zam");
}

TEST(Config, TellsKindsApart) {
  const ConfigNode node = ConfigNode::parse("map: {a: 1}\nlist: [1]\nword: x\nnothing:");
  EXPECT_TRUE(node.at("map").is_map());
  EXPECT_TRUE(node.at("list").is_list());
  EXPECT_TRUE(node.at("word").is_scalar());
  EXPECT_TRUE(node.at("nothing").is_null());
}

TEST(Config, AnAnchorsCopiesAreReadApart) {
  const ConfigNode node = ConfigNode::parse("a: &noise {x: 1}\nb: *noise\n");
  EXPECT_EQ(node.at("b").require<int>("x"), 1);
  EXPECT_EQ(node.at("b").at("x").path(), "b.x");
  EXPECT_EQ(node.at("a").line(), 1);
  EXPECT_THROW(node.reject_unused(), ConfigError);  // a.x was not read
}

TEST(Config, ResolvesPathsAgainstTheFile) {
  const test::TemporaryFolder folder;
  const ConfigNode node = ConfigNode::load(folder.write("sub/v.yaml", "urdf: ../x.urdf\n"));
  EXPECT_EQ(node.resolve(node.require<std::string>("urdf")), folder.path() / "x.urdf");
  EXPECT_EQ(node.resolve("/abs/x"), "/abs/x");
}

TEST(Config, DumpsATextThatReadsBackAlike) {
  const std::string text =
      "name: \"5\"\nrate_hz: 5\nlist: [1, {a: b}]\nmap:\n  deep: [x, \"true\"]\nnothing:\n";
  const std::string dumped = ConfigNode::parse(text).dump();
  const ConfigNode node = ConfigNode::parse(dumped);
  EXPECT_EQ(node.dump(), dumped);
  EXPECT_EQ(node.require<std::string>("name"), "5");
  EXPECT_THROW(node.require<double>("name"), ConfigError);
  EXPECT_EQ(node.require<double>("rate_hz"), 5.0);
  EXPECT_EQ(node.at("list").items()[1].require<std::string>("a"), "b");
  EXPECT_TRUE(node.at("nothing").is_null());
}

TEST(Config, AnotherProgramsBlockIsLeftToItsOwnReader) {
  const ConfigNode node = ConfigNode::parse("sensors:\n  imu: {rat_hz: 5}\n");
  const ConfigNode sensors = node.at("sensors");
  sensors.mark_used();
  EXPECT_NO_THROW(node.reject_unused());
  const ConfigNode imu = sensors.at("imu");
  EXPECT_FALSE(imu.find("rate_hz"));
  EXPECT_THROW(imu.reject_unused(), ConfigError);
}

TEST(Config, AMapOverDefaultsHasTheKeysOfBoth) {
  const ConfigNode own = ConfigNode::parse("rate_hz: 250", "world.yaml");
  const ConfigNode preset = ConfigNode::parse("rate_hz: 500\nnoise: x\n", "vehicle.yaml");
  const ConfigNode node = own.merged_over(preset);
  EXPECT_EQ(node.require<double>("rate_hz"), 250);
  EXPECT_EQ(node.require<std::string>("noise"), "x");
  EXPECT_EQ(node.entries().size(), 2U);
  EXPECT_EQ(node.at("noise").file(), "vehicle.yaml");
  EXPECT_EQ(node.at("rate_hz").file(), "world.yaml");
  EXPECT_NO_THROW(node.reject_unused());
}

TEST(Config, AnUnknownKeyOfTheDefaultsIsRefusedToo) {
  const ConfigNode preset = ConfigNode::parse("noize: x\n", "vehicle.yaml");
  const ConfigNode node = ConfigNode::empty().merged_over(preset);
  node.find("noise");
  EXPECT_THROW(node.reject_unused(), ConfigError);
}

TEST(Config, ANodeOutlivesTheOneItCameFrom) {
  std::optional<ConfigNode> child;
  child = ConfigNode::parse("a: {b: 7}").at("a");
  EXPECT_EQ(child->require<int>("b"), 7);
}

}  // namespace
}  // namespace cas::base
