// SPDX-License-Identifier: BSD-3-Clause
// The files beside a file: of a topology, and of mavlink-router's configuration.
#include <gtest/gtest.h>
#include <signal.h>

#include <nlohmann/json.hpp>

#include "base/rpc/client.hpp"
#include "tests/loopback/casd_fixture.hpp"
#include "tests/loopback/running_casd.hpp"

namespace cas::test {
namespace {

const std::string kBase =
    std::string("command_port: {port: 0, loopback_without_token: true}\n") + kHilTopology;
const std::string kStation =
    "schema: 1\nlinks:\n  - {name: gcs, type: udp_server, local: \"127.0.0.1:0\"}\n"
    "routes:\n  - {from: fcu, to: gcs}\n";

class CasdOverlay : public testing::Test {
 protected:
  std::string write(const std::string& name, const std::string& yaml) {
    return fixture.folder.write(name, fixture.expand(yaml));
  }
  static std::string output(const std::vector<std::string>& arguments, int exit_code = 0) {
    std::vector<std::string> command{kCasdProgram};
    command.insert(command.end(), arguments.begin(), arguments.end());
    ChildProcess casd(command);
    EXPECT_EQ(casd.wait_exit(), exit_code) << casd.output();
    return casd.output();
  }
  CasdFixture fixture;
};

TEST_F(CasdOverlay, CheckShowsTheFilesAndWhatTheyComeTo) {
  const std::string file = write("t.yaml", kBase);
  const std::string over = write("t.d/10-station.yaml", kStation);
  write("t.d/20-line.yaml", "schema: 1\nlinks: [{name: fcu, baud: [57600, 921600]}]\n");
  const std::string said = output({"--check", file});
  EXPECT_NE(said.find(": 3 links, 3 routes\n"), std::string::npos) << said;
  EXPECT_NE(said.find("  " + over + "\n"), std::string::npos) << said;
  EXPECT_NE(said.find(" at 57600 or 921600 baud, paced"), std::string::npos) << said;
  EXPECT_EQ(output({"--check", fixture.folder / "t.d"}, 78).find(" links, "), std::string::npos);

  write("t.d/20-line.yaml", "schema: 1\nlinks:\n  - {name: fcu, baud: fast}\n");
  EXPECT_NE(output({"--check", file}, 78).find("t.d/20-line.yaml:3: links[0].baud: "),
            std::string::npos);
}

TEST_F(CasdOverlay, AReloadReadsTheFolderAgain) {
  const std::string file = write("t.yaml", kBase);
  RunningCasd casd({kCasdProgram, file});
  const auto links = [&] { return casd.call("link.list").size(); };
  EXPECT_EQ(links(), 2U);

  const std::string over = write("t.d/gcs.yaml", kStation);
  casd.call("casd.reload");
  EXPECT_EQ(links(), 3U);

  write("t.d/gcs.yaml", "schema: 1\nthreads: single\n");
  const std::string refused = casd.refusal("casd.reload");
  EXPECT_NE(refused.find(over + ":2: threads: takes a restart"), std::string::npos) << refused;
  EXPECT_EQ(links(), 3U);

  std::filesystem::remove_all(fixture.folder / "t.d");
  casd.call("casd.reload");
  EXPECT_EQ(links(), 2U);
}

TEST_F(CasdOverlay, AFolderAloneIsATopologyToo) {
  write("casd.d/00-base.yaml", kBase);
  write("casd.d/10-station.yaml", kStation);
  RunningCasd casd({kCasdProgram, fixture.folder / "casd.d"});
  EXPECT_NE(casd.status.find(" gcs 127.0.0.1:"), std::string::npos) << casd.status;
  casd.signal(SIGTERM);
  EXPECT_EQ(casd.wait_exit(), 0) << casd.output();
}

TEST_F(CasdOverlay, TheImportOfMavlinkRouterReadsConfigD) {
  const std::string conf =
      write("main.conf", "[General]\nTcpServerPort = 0\n[UartEndpoint fc]\nDevice = /dev/ttyS1\n");
  write("config.d/20.conf", "[uartendpoint FC]\nBaud = 57600,921600\n");
  write("config.d/10.conf",
        "[UartEndpoint fc]\nBaud = 9600\n[General]\nLog = /tmp/x\nLogTelemetry = true\n"
        "MaxLogFiles = 5\n");
  const std::string said = output({"--import", conf});
  EXPECT_NE(said.find("config.d/10.conf:6: MaxLogFiles: "), std::string::npos) << said;
  const std::string yaml = said.substr(said.find("# From"));
  const std::string check = output({"--check", fixture.folder.write("printed.yaml", yaml)});
  EXPECT_NE(check.find("/dev/ttyS1 at 57600 or 921600 baud"), std::string::npos) << check;
  EXPECT_NE(yaml.find("max_files: 5"), std::string::npos) << yaml;

  write("elsewhere/10.conf", "[UartEndpoint fc]\nBaud = 230400\n");
  const std::string other =
      output({"--import", conf, "--conf-dir", (fixture.folder / "elsewhere").string()});
  EXPECT_NE(other.find("baud: 230400"), std::string::npos) << other;
  EXPECT_EQ(other.find("max_files"), std::string::npos) << other;
}

}  // namespace
}  // namespace cas::test
