// SPDX-License-Identifier: BSD-3-Clause
#include "casd/topology/topology_files.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <string>

#include "base/error.hpp"
#include "casd/topology/topology.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::casd::test {
namespace {

namespace fs = std::filesystem;

const std::string kBase =
    "schema: 1\n"
    "system_id: 200\n"
    "command_port: {port: 1, address: '::1'}\n"
    "links:\n"
    "  - {name: fcu, type: serial, device: /dev/a, baud: 57600, queue: {hil_max_age_ms: 9}}\n"
    "  - {name: gcs, type: udp_server, local: '127.0.0.1:1', accept: nothing}\n"
    "routes:\n"
    "  - {from: fcu, to: gcs, block: [HEARTBEAT]}\n"
    "  - {from: gcs, to: fcu}\n";

class TopologyFiles : public testing::Test {
 protected:
  TopologyFiles() {
    fs::create_directory(folder_ / "t.d");
    ::chmod((folder_ / "t.d").c_str(), 0755);  // whatever the umask
  }
  void overlay(const std::string& name, const std::string& yaml) {
    folder_.write("t.d/" + name, "schema: 1\n" + yaml);
  }
  Topology load(const std::string& base = kBase) {
    return Topology::load(folder_.write("t.yaml", base));
  }
  /// The error, without the path of the folder.
  std::string fault(const std::string& base = kBase) {
    std::string text = cas::test::refusal([&] { load(base); });
    const std::string path = folder_.path().string() + "/";
    for (std::size_t at = text.find(path); at != text.npos; at = text.find(path)) {
      text.erase(at, path.size());
    }
    return text;
  }
  cas::test::TemporaryFolder folder_;
};

TEST_F(TopologyFiles, LaterFilesOverrideKeysOfBlocksAndLinksInTheOrderOfTheirNames) {
  overlay("20-b.yaml", "system_id: 202\nlinks: [{name: fcu, baud: [57600, 921600]}]\n");
  overlay("10-a.yaml",
          "system_id: 201\ncommand_port: {port: 2}\n"
          "links: [{name: fcu, device: /dev/b, queue: {gps_max_age_ms: 8}}]\n");
  const Topology topology = load();
  EXPECT_EQ(topology.self.system, 202);
  EXPECT_EQ(topology.command_port.port, 2);
  EXPECT_EQ(topology.command_port.address, "::1");
  ASSERT_EQ(topology.links.size(), 2U);
  const LinkConfig& fcu = topology.links[0];
  EXPECT_EQ(fcu.device, "/dev/b");
  EXPECT_EQ(fcu.baud, (std::vector<unsigned>{57600, 921600}));
  EXPECT_EQ(fcu.queue.hil_max_age, std::chrono::milliseconds(9));
  EXPECT_EQ(fcu.queue.gps_max_age, std::chrono::milliseconds(8));
  EXPECT_TRUE(topology.links[1].accept.read_only);
}

TEST_F(TopologyFiles, LinksAndRoutesAreAppendedAndARouteOfTheSameEndsIsOverlaid) {
  overlay("a.yaml",
          "links: [{name: radio, type: udp, remote: '127.0.0.1:2'}]\n"
          "routes: [{from: fcu, to: gcs, block: [ATTITUDE]}, {from: fcu, to: radio}]\n");
  const Topology topology = load();
  ASSERT_EQ(topology.links.size(), 3U);
  EXPECT_EQ(topology.links[2].name, "radio");
  ASSERT_EQ(topology.routes.size(), 3U);
  EXPECT_EQ(topology.routes[0].rule.block, std::vector<std::uint32_t>{30});
  EXPECT_EQ(topology.routes[2].to, "radio");
}

TEST_F(TopologyFiles, AnyOfAnEarlierFileMeansLinksOfLaterOnesToo) {
  overlay("a.yaml", "links: [{name: radio, type: udp, remote: '127.0.0.1:2'}]\n");
  const std::string base =
      kBase.substr(0, kBase.find("routes")) + "routes: [{from: any, to: any}]\n";
  EXPECT_EQ(load(base).routes.size(), 6U);
}

TEST_F(TopologyFiles, RelativePathsStartAtTheFolderOfTheirOwnFile) {
  overlay("a.yaml", "links: [{name: gcs, signing: {key_file: radio.key}}]\n");
  EXPECT_EQ(load().links[1].signing->key_file, folder_ / "t.d/radio.key");
}

TEST_F(TopologyFiles, ErrorsNameTheFileAndLineOfTheValue) {
  overlay("a.yaml", "links:\n  - {name: gcs, max_peers: 3}\n  - {name: fcu, baud: fast}\n");
  EXPECT_TRUE(fault().starts_with("t.d/a.yaml:4: links[1].baud: ")) << fault();
  overlay("a.yaml", "links:\n  - {name: fcu, bauds: 9600}\n");
  EXPECT_TRUE(fault().starts_with("t.d/a.yaml:3: links[0].bauds: unknown key")) << fault();
  overlay("a.yaml", "sistem_id: 3\n");
  EXPECT_TRUE(fault().starts_with("t.d/a.yaml:2: sistem_id: unknown key")) << fault();
  overlay("a.yaml", "links:\n  - {name: gcs, type: tcp_server}\n");
  EXPECT_EQ(fault(), "") << "a type may change where the other keys fit";
  overlay("a.yaml", "links:\n  - {name: fcu, type: tcp_server}\n");
  EXPECT_TRUE(fault().starts_with("t.d/a.yaml:3: links[0]: key 'local' is missing")) << fault();
  overlay("a.yaml",
          "links:\n  - {name: x, type: udp, local: '[::1]:0'}\n"
          "  - {name: x, type: udp, local: '[::1]:0'}\n");
  EXPECT_EQ(fault(), "t.d/a.yaml:4: links[1].name: 'x' is the name of another link");
  overlay("a.yaml", "links:\n  - {name: gcs, max_peers: 3}\n  - {name: gcs, max_peers: 4}\n");
  EXPECT_EQ(fault(), "t.d/a.yaml:4: links[1]: is in this file already");
  overlay("a.yaml", "routes:\n  - {from: any, to: gcs}\n");
  EXPECT_TRUE(fault().starts_with("t.d/a.yaml:3: routes[0]: there is another route")) << fault();
  folder_.write("t.d/a.yaml", "system_id: 3\n");
  EXPECT_TRUE(fault().find("key 'schema' is missing") != std::string::npos) << fault();
  folder_.write("t.d/a.yaml", "schema: 2\n");
  EXPECT_TRUE(fault().starts_with("t.d/a.yaml:1: schema: ")) << fault();
}

TEST_F(TopologyFiles, RestartKeysAreRefusedAtTheFileThatHasThem) {
  const Topology before = load();
  overlay("a.yaml", "threads: single\n");
  const auto files = load_topology_files(folder_ / "t.yaml");
  EXPECT_EQ(cas::test::refusal(
                [&] { refuse_restart_keys(before, Topology::parse(files), overlaid(files)); }),
            folder_.path().string() + "/t.d/a.yaml:2: threads: takes a restart");
}

TEST_F(TopologyFiles, OtherFilesOfTheFolderAreLeftAlone) {
  for (const char* name : {"a.yaml~", ".b.yaml", "c.conf"})
    folder_.write(std::string("t.d/") + name, "?");
  fs::create_directory(folder_ / "t.d/d.yaml");
  EXPECT_EQ(load_topology_files(folder_.write("t.yaml", kBase)).size(), 1U);
}

TEST_F(TopologyFiles, AFolderStandsForItsFiles) {
  EXPECT_THROW(load_topology_files(folder_ / "t.d"), base::ConfigError);
  folder_.write("t.d/00.yaml", kBase);
  overlay("10.yaml", "system_id: 7\n");
  EXPECT_EQ(Topology::load(folder_ / "t.d").self.system, 7);
}

TEST_F(TopologyFiles, AFolderThatAnybodyMayWriteToIsRefused) {
  overlay("a.yaml", "system_id: 7\n");
  ASSERT_EQ(::chmod((folder_ / "t.d").c_str(), 0777), 0);
  EXPECT_TRUE(fault().starts_with("t.d: everybody may write to it")) << fault();
  ASSERT_EQ(::chmod((folder_ / "t.d").c_str(), 0755), 0);
  EXPECT_EQ(fault(), "");
  ASSERT_EQ(::chmod((folder_ / "t.d/a.yaml").c_str(), 0666), 0);
  EXPECT_TRUE(fault().starts_with("t.d/a.yaml: everybody may write to it")) << fault();
  ASSERT_EQ(::chmod((folder_ / "t.d/a.yaml").c_str(), 0644), 0);
  constexpr uid_t kNobody = 65534;
  if (::chown((folder_ / "t.d").c_str(), kNobody, static_cast<gid_t>(-1)) != 0) {
    GTEST_SKIP() << "only root gives folders away";
  }
  EXPECT_TRUE(fault().starts_with("t.d: belongs to another user than t.yaml")) << fault();
  ASSERT_EQ(::chown((folder_ / "t.d").c_str(), 0, static_cast<gid_t>(-1)), 0);
  ASSERT_EQ(::chown((folder_ / "t.d/a.yaml").c_str(), kNobody, static_cast<gid_t>(-1)), 0);
  EXPECT_TRUE(fault().starts_with("t.d/a.yaml: belongs to another user than t.yaml")) << fault();
}

TEST_F(TopologyFiles, AGroupThatMayNotWriteTheFileMayNotOverlayItEither) {
  overlay("a.yaml", "system_id: 7\n");
  const fs::path file = folder_.write("t.yaml", kBase);
  constexpr gid_t kGroup = 4711;
  const auto give = [](const fs::path& path, mode_t mode) {
    return ::chown(path.c_str(), static_cast<uid_t>(-1), kGroup) == 0 &&
           ::chmod(path.c_str(), mode) == 0;
  };
  if (!give(folder_ / "t.d", 0775)) GTEST_SKIP() << "only root gives folders to any group";
  EXPECT_TRUE(fault().starts_with("t.d: its group may write to it, but not to t.yaml")) << fault();
  ASSERT_TRUE(give(file, 0664));
  EXPECT_EQ(fault(), "");
  ASSERT_TRUE(give(file, 0644) && give(folder_ / "t.d", 0755) &&
              give(folder_ / "t.d/a.yaml", 0664));
  EXPECT_TRUE(fault().starts_with("t.d/a.yaml: its group may write to it")) << fault();
}

TEST_F(TopologyFiles, AFileWithAnotherSpellingOfYamlIsNoSilentNothing) {
  overlay("a.yml", "system_id: 7\n");
  EXPECT_EQ(fault(), "t.d/a.yml: the name of a topology's file ends in .yaml");
}

}  // namespace
}  // namespace cas::casd::test
