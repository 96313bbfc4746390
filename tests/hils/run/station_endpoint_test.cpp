// SPDX-License-Identifier: BSD-3-Clause
#include "hils/run/station_endpoint.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "base/error.hpp"
#include "hils/programs/watch_line.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::hils {
namespace {

TEST(Endpoints, AreTakenApart) {
  struct EndpointCase {
    const char* name;
    const char* text;
    const char* type;
    const char* address;
  };
  const EndpointCase rows[] = {
      {"Port", "udp:14550", "udp", "127.0.0.1:14550"},
      {"Host", "udp:lab-pc:14550", "udp", "lab-pc:14550"},
      {"IPv6", "udp:[::1]:14550", "udp", "[::1]:14550"},
      {"UdpServer", "udp_server:1", "udp_server", "127.0.0.1:1"},
      {"AnyAddress", "udp_server:0.0.0.0:65535", "udp_server", "0.0.0.0:65535"},
      {"TcpServer", "tcp_server:5761", "tcp_server", "127.0.0.1:5761"}};
  for (const auto& test : rows) {
    SCOPED_TRACE(test.name);
    const StationEndpoint station = StationEndpoint::parse(test.text);
    EXPECT_EQ(station.type, test.type);
    EXPECT_EQ(station.address, test.address);
  }
}

TEST(StationEndpoint, RefusesWhatNoStationCanUse) {
  for (const char* text :
       {"", "udp", "udp:", "udp:0", "udp:65536", "udp:port", "udp::14550", "udp:host:", "14550",
        "127.0.0.1:14550", "serial:/dev/ttyUSB0", "tcp:14550", "udp:1:2:3x"}) {
    EXPECT_THROW(StationEndpoint::parse(text), base::ConfigError) << text;
  }
}

TEST(WatchLine, NamesTheAddressAndTheStationWhereThereAreAny) {
  EXPECT_EQ(watch_line("casctl", {}, {}), "Watch it: casctl monitor");
  EXPECT_EQ(watch_line("casctl", "unix:/run/x", {}),
            "Watch it: casctl --address unix:/run/x monitor");
  EXPECT_EQ(watch_line("casctl", {}, StationEndpoint::parse("udp:14550")),
            "Watch it: casctl monitor; a ground station at 127.0.0.1:14550 is sent to over UDP");
  EXPECT_EQ(watch_line("casctl", {}, StationEndpoint::parse("tcp_server:5761")),
            "Watch it: casctl monitor; a ground station joins at 127.0.0.1:5761 over TCP");
}

TEST(WatchLine, NamesACasctlThatTheShellFinds) {
  const cas::test::TemporaryFolder folder;
  const auto make = [&folder](const std::string& name) {
    std::filesystem::permissions(folder.write(name, ""), std::filesystem::perms::owner_all);
  };
  const auto command = [&folder](const std::string& from, const std::string& path) {
    return casctl_command(folder / "build/bin", folder / from, path);
  };
  EXPECT_EQ(command("", "/nowhere"), "casctl") << "there is none";
  make("build/bin/casctl");
  EXPECT_EQ(command("", "/nowhere"), "build/bin/casctl");
  EXPECT_EQ(command("build/bin", ""), "./casctl");
  EXPECT_EQ(command("elsewhere", ""), (folder / "build/bin/casctl").string());
  make("usr/bin/casctl");
  EXPECT_EQ(command("", "/nowhere::" + (folder / "usr/bin").string()), "casctl");
}

}  // namespace
}  // namespace cas::hils
