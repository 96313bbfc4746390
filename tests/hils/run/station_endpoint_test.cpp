// SPDX-License-Identifier: BSD-3-Clause
#include "hils/run/station_endpoint.hpp"

#include <gtest/gtest.h>

#include "base/error.hpp"
#include "hils/programs/watch_line.hpp"

namespace cas::hils {
namespace {

struct EndpointCase {
  const char* name;
  const char* text;
  const char* type;
  const char* address;
};

class Endpoints : public testing::TestWithParam<EndpointCase> {};

TEST_P(Endpoints, AreTakenApart) {
  const EndpointCase& test = GetParam();
  const StationEndpoint station = StationEndpoint::parse(test.text);
  EXPECT_EQ(station.type, test.type);
  EXPECT_EQ(station.address, test.address);
}

INSTANTIATE_TEST_SUITE_P(
    Of, Endpoints,
    testing::Values(EndpointCase{"Port", "udp:14550", "udp", "127.0.0.1:14550"},
                    EndpointCase{"Host", "udp:lab-pc:14550", "udp", "lab-pc:14550"},
                    EndpointCase{"IPv6", "udp:[::1]:14550", "udp", "[::1]:14550"},
                    EndpointCase{"UdpServer", "udp_server:1", "udp_server", "127.0.0.1:1"},
                    EndpointCase{"AnyAddress", "udp_server:0.0.0.0:65535", "udp_server",
                                 "0.0.0.0:65535"},
                    EndpointCase{"TcpServer", "tcp_server:5761", "tcp_server", "127.0.0.1:5761"}),
    [](const auto& test) { return test.param.name; });

TEST(StationEndpoint, RefusesWhatNoStationCanUse) {
  for (const char* text :
       {"", "udp", "udp:", "udp:0", "udp:65536", "udp:port", "udp::14550", "udp:host:", "14550",
        "127.0.0.1:14550", "serial:/dev/ttyUSB0", "tcp:14550", "udp:1:2:3x"}) {
    EXPECT_THROW(StationEndpoint::parse(text), base::ConfigError) << text;
  }
}

TEST(WatchLine, NamesTheAddressAndTheStationWhereThereAreAny) {
  EXPECT_EQ(watch_line({}, {}), "Watch it: casctl monitor");
  EXPECT_EQ(watch_line("unix:/run/x", {}), "Watch it: casctl --address unix:/run/x monitor");
  EXPECT_EQ(watch_line({}, StationEndpoint::parse("udp:14550")),
            "Watch it: casctl monitor; a ground station at 127.0.0.1:14550 is sent to over UDP");
  EXPECT_EQ(watch_line({}, StationEndpoint::parse("tcp_server:5761")),
            "Watch it: casctl monitor; a ground station joins at 127.0.0.1:5761 over TCP");
}

}  // namespace
}  // namespace cas::hils
