// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <netinet/in.h>
#include <signal.h>
#include <sys/socket.h>
#include <unistd.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/rpc/client.hpp"
#include "tests/loopback/any_udp_peer.hpp"
#include "tests/loopback/casd_fixture.hpp"
#include "tests/loopback/running_casd.hpp"
#include "tests/loopback/tcp_peer.hpp"
#include "tests/support/ended_with.hpp"
#include "tests/support/free_port.hpp"

namespace cas::test {
namespace {

using testing::HasSubstr;

class CasdProgram : public testing::Test {
 protected:
  std::string topology(const std::string& yaml) {
    return fixture.folder.write("topology.yaml", fixture.expand(yaml));
  }
  CasdFixture fixture;
};

const std::string kWithPort =
    std::string("command_port: {port: 0, loopback_without_token: true}\n") + kHilTopology;

TEST_F(CasdProgram, TellsItsBoundPortsForwardsAndEndsCleanly) {
  const auto stats = fixture.folder / "stats.json";
  RunningCasd casd({kCasdProgram, topology(kWithPort), "--stats", stats});
  fixture.sim.set_remote(casd.port("sim"));

  fixture.sim.send(fixture.from_sim(hil_sensor(1)));
  fixture.fcu.write(fixture.from_fcu(hil_controls(1)));
  ASSERT_TRUE(fixture.collect_until([&] {
    return fixture.at_fcu.count(kHilSensor) == 1 && fixture.at_sim.count(kHilControls) == 1;
  }));
  casd.signal(SIGTERM);
  EXPECT_EQ(casd.wait_exit(), 0) << casd.output();
  const auto figures = nlohmann::json::parse(std::ifstream(stats));
  EXPECT_EQ(figures["program"], "casd");
  EXPECT_EQ(figures["links"].size(), 2U);
}

TEST_F(CasdProgram, AnswersOnTheCommandPort) {
  RunningCasd casd({kCasdProgram, topology(kWithPort)});
  const auto answer = casd.call("casd.status");
  EXPECT_EQ(answer["threads"], "auto");
  EXPECT_EQ(answer["links"][0]["state"], "up");
}

TEST_F(CasdProgram, ReloadsOnHangupAndKeepsTheOldTopologyWhenTheNewOneIsBad) {
  RunningCasd casd({kCasdProgram, topology(kWithPort)});
  const auto links = [&] { return casd.call("link.list").size(); };

  topology(kWithPort + "  - {from: sim, to: nowhere}\n");
  casd.signal(SIGHUP);
  ASSERT_TRUE(casd.prints("not reloaded"));
  EXPECT_THAT(casd.output(), HasSubstr("there is no link 'nowhere'"));
  EXPECT_EQ(links(), 2U);

  std::string more = kWithPort;
  more.insert(more.find("routes:"), "  - {name: gcs, type: udp_server, local: \"127.0.0.1:0\"}\n");
  topology(more);
  casd.signal(SIGHUP);
  ASSERT_TRUE(wait_until([&] { return links() == 3; }));
}

TEST_F(CasdProgram, RoutesBetweenEndpointsOfTheCommandLineButNoSensorsOfASimulator) {
  RunningCasd casd({kCasdProgram, "--command-port", "0",
                    "serial:" + fixture.expand("$FCU") + ":921600",
                    "udp:" + fixture.expand("$SIM")});
  fixture.sim.set_remote(casd.port("udp"));

  fixture.fcu.write(fixture.from_fcu(hil_controls(1)));
  fixture.sim.send(fixture.from_sim(hil_sensor(1)));
  fixture.sim.send(fixture.from_sim(mavlink::common::ParamRequestList{}));
  ASSERT_TRUE(fixture.collect_until([&] {
    return fixture.at_sim.count(kHilControls) == 1 &&
           fixture.at_fcu.count(mavlink::common::ParamRequestList::kId) == 1;
  })) << casd.output();
  EXPECT_EQ(fixture.at_fcu.count(kHilSensor), 0U);

  casd.signal(SIGHUP);
  EXPECT_TRUE(casd.prints("there is nothing to read again")) << casd.output();
  casd.signal(SIGTERM);
  EXPECT_EQ(casd.wait_exit(), 0) << casd.output();
}

TEST_F(CasdProgram, TakesNoFlagForAForgottenValue) {
  for (const std::vector<std::string>& arguments :
       {std::vector<std::string>{"-e", "--check"}, {"-l", "--check", "udp:0"}}) {
    std::vector<std::string> command{kCasdProgram};
    command.insert(command.end(), arguments.begin(), arguments.end());
    EXPECT_THAT(ChildProcess(command).end(), EndedWith(78, "'--check' is a flag, and no value"));
  }
}

/// The other end of an endpoint on the command line.
enum class OtherEnd {
  kUdpSentTo,   ///< casd sends to its socket ($SIM)
  kUdpClient,   ///< sends to casd's socket
  kTcpClient,   ///< connects to casd
  kTcpListener  ///< casd connects to it ($TCP)
};

struct CommandLine {
  const char* name;
  std::vector<std::string> arguments;  ///< with $FCU, $SIM, $TCP and a free port, $PORT
  OtherEnd other_end;
};

class CasdCommandLine : public CasdProgram, public testing::WithParamInterface<CommandLine> {
 protected:
  CasdCommandLine() {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    auto* const any = reinterpret_cast<sockaddr*>(&address);
    listener_ = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    EXPECT_EQ(::bind(listener_, any, size), 0);
    EXPECT_EQ(::listen(listener_, 4), 0);
    ::getsockname(listener_, any, &size);
    tcp_place_ = "127.0.0.1:" + std::to_string(ntohs(address.sin_port));
  }
  ~CasdCommandLine() override { ::close(listener_); }

  std::vector<std::string> command() {
    const std::string port = std::to_string(free_port());
    std::vector<std::string> all{kCasdProgram, "--command-port", "0"};
    for (std::string argument : GetParam().arguments) {
      for (const auto& [word, by] :
           {std::pair{std::string("$TCP"), tcp_place_}, std::pair{std::string("$PORT"), port}}) {
        const std::size_t at = argument.find(word);
        if (at != argument.npos) argument.replace(at, word.size(), by);
      }
      all.push_back(fixture.expand(argument));
    }
    return all;
  }
  /// Connects to casd, or takes its connection.
  void connect(const std::string& status) {
    if (GetParam().other_end == OtherEnd::kUdpClient ||
        GetParam().other_end == OtherEnd::kUdpSentTo) {
      fixture.sim.set_remote(port_of(word_after(status, "udp")));
    } else if (GetParam().other_end == OtherEnd::kTcpClient) {
      tcp_.emplace(port_of(word_after(status, "tcp")));
    } else if (GetParam().other_end == OtherEnd::kTcpListener) {
      int accepted = -1;
      ASSERT_TRUE(wait_until([&] {
        accepted = ::accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC);
        return accepted >= 0;
      }));
      tcp_.emplace(accepted, true);
    }
  }
  void say(std::span<const std::uint8_t> bytes) {
    tcp_ ? tcp_->send(bytes) : fixture.sim.send(bytes);
  }

  int listener_ = -1;
  std::string tcp_place_;
  std::optional<TcpPeer> tcp_;
};

TEST_P(CasdCommandLine, ConnectsALineWithTheOtherEnd) {
  RunningCasd casd(command());
  ASSERT_NO_FATAL_FAILURE(connect(casd.status)) << casd.output();
  using mavlink::common::ParamRequestList;
  // Repeated: a peer that has not been heard yet gets nothing.
  EXPECT_TRUE(fixture.collect_until([&] {
    say(fixture.from_sim(ParamRequestList{}));
    fixture.fcu.write(fixture.from_fcu(hil_controls(1)));
    if (tcp_) tcp_->read(fixture.at_sim);
    return fixture.at_sim.count(kHilControls) > 0 &&
           fixture.at_fcu.count(ParamRequestList::kId) > 0;
  })) << casd.status
      << casd.output();
}

INSTANTIATE_TEST_SUITE_P(
    Notations, CasdCommandLine,
    testing::Values(
        CommandLine{"UdpHostAndPort", {"serial:$FCU:921600", "udp:$SIM"}, OtherEnd::kUdpSentTo},
        CommandLine{"UdpPort", {"serial:$FCU", "udp:0"}, OtherEnd::kUdpClient},
        CommandLine{"TcpPort", {"serial:$FCU", "tcp:0"}, OtherEnd::kTcpClient},
        CommandLine{"TcpHostAndPort", {"serial:$FCU", "tcp:$TCP"}, OtherEnd::kTcpListener},
        CommandLine{
            "MavproxysOut", {"--master", "$FCU,921600", "--out", "$SIM"}, OtherEnd::kUdpSentTo},
        CommandLine{"MavproxysOutTcpin",
                    {"--master", "$FCU", "--baudrate", "921600", "--out", "tcpin:127.0.0.1:0"},
                    OtherEnd::kTcpClient},
        CommandLine{"MavproxysMasterUdp",
                    {"--master", "udp:127.0.0.1:0", "--out", "$FCU"},
                    OtherEnd::kUdpClient},
        CommandLine{
            "MavproxysMasterTcp", {"--master", "tcp:$TCP", "serial:$FCU"}, OtherEnd::kTcpListener},
        CommandLine{"MavlinkRoutersE", {"-e", "$SIM", "serial:$FCU:921600"}, OtherEnd::kUdpSentTo},
        CommandLine{
            "MavlinkRoutersServer", {"serial:$FCU:921600", "127.0.0.1:0"}, OtherEnd::kUdpClient},
        CommandLine{
            "MavlinkRoutersP", {"-p", "$TCP", "serial:$FCU:921600"}, OtherEnd::kTcpListener},
        CommandLine{
            "MavlinkRoutersT", {"-t", "$PORT", "serial:$FCU:921600"}, OtherEnd::kTcpClient}),
    [](const auto& test) { return std::string(test.param.name); });

TEST_F(CasdProgram, SpeaksToABroadcastAddressOfTheCommandLine) {
  AnyUdpPeer peer("0.0.0.0:0");
  const std::string port = peer.endpoint().substr(peer.endpoint().rfind(':'));
  RunningCasd casd({kCasdProgram, "--command-port", "0", "serial:" + fixture.expand("$FCU"),
                    "udpcast:127.255.255.255" + port});
  const std::string own = "127.0.0.1:" + std::to_string(casd.port("udp"));
  PacketStream heard;
  EXPECT_TRUE(fixture.collect_until([&] {
    fixture.fcu.write(fixture.from_fcu(hil_controls(1)));
    peer.send(own, fixture.from_sim(mavlink::common::ParamRequestList{}));
    peer.read(heard);
    return heard.count(kHilControls) > 0 &&
           fixture.at_fcu.count(mavlink::common::ParamRequestList::kId) > 0;
  })) << casd.status
      << casd.output();
}

TEST_F(CasdProgram, SpeaksToAMulticastGroupInMavproxysNotation) {
  const std::string group = "239.255.77.78:" + std::to_string(free_port());
  AnyUdpPeer peer("0.0.0.0" + group.substr(group.rfind(':')));
  AnyUdpPeer sender("127.0.0.1:0");  // on one machine the shared port would be casd's
  if (!peer.bound() || !peer.join("239.255.77.78") || !sender.join("239.255.77.78")) {
    GTEST_SKIP() << "no multicast on lo";
  }
  ChildProcess printed(
      {kCasdProgram, "--as-topology", "serial:" + fixture.expand("$FCU"), "mcast:" + group});
  ASSERT_EQ(printed.wait_exit(), 0) << printed.output();
  // The notation names no device: that of the default route, which no test speaks on.
  std::string yaml = printed.output();
  const std::size_t at = yaml.find("type: udp,");
  ASSERT_NE(at, yaml.npos) << yaml;
  yaml.insert(at, "interface: lo, ");
  ChildProcess casd({kCasdProgram, topology("command_port: {port: 0}\n" + yaml)});
  ASSERT_TRUE(casd.wait_ready()) << casd.output();

  PacketStream heard;
  const auto both_ways = [&](std::size_t times) {
    return fixture.collect_until([&] {
      fixture.fcu.write(fixture.from_fcu(hil_controls(1)));
      sender.send(group, fixture.from_sim(mavlink::common::ParamRequestList{}));
      peer.read(heard);
      return heard.count(kHilControls) >= times &&
             fixture.at_fcu.count(mavlink::common::ParamRequestList::kId) >= times;
    });
  };
  EXPECT_TRUE(both_ways(1)) << casd.output();
  EXPECT_TRUE(both_ways(5)) << casd.output();
  EXPECT_EQ(fixture.at_fcu.count(kHilControls), 0U) << "an echo of its own packets";
}

TEST_F(CasdProgram, PeersOfOneEndpointHearEachOther) {
  RunningCasd casd({kCasdProgram, "--command-port", "0", "udp:0"});
  UdpPeer vehicle;
  UdpPeer station;
  PacketStream at_vehicle;
  PacketStream at_station;
  for (UdpPeer* peer : {&vehicle, &station}) peer->set_remote(casd.port("udp"));
  mav::Encoder encode({255, 190});
  EXPECT_TRUE(wait_until([&] {
    vehicle.send(fixture.from_fcu(mavlink::common::Attitude{}));
    station.send(encode(mavlink::common::ParamRequestList{}));
    vehicle.read(at_vehicle);
    station.read(at_station);
    return at_vehicle.count(mavlink::common::ParamRequestList::kId) > 0 &&
           at_station.count(mavlink::common::Attitude::kId) > 0;
  })) << casd.output();
  EXPECT_EQ(at_vehicle.count(mavlink::common::Attitude::kId), 0U) << "nothing comes back";
}

TEST_F(CasdProgram, ASecondOneSaysHowItGetsACommandPort) {
  RunningCasd first({kCasdProgram, topology(kWithPort)});
  const std::string place = first.address();
  ChildProcess second(
      {kCasdProgram, "--command-port", place.substr(place.rfind(':') + 1), "udp:0"});
  EXPECT_NE(second.wait_exit(), 0);
  EXPECT_THAT(second.output(), HasSubstr("casd: command port " + place + ": cannot listen: "));
  EXPECT_THAT(second.output(), HasSubstr("'--command-port N'"));
}

TEST_F(CasdProgram, KeepsToAFastHeartbeat) {
  ChildProcess casd({kCasdProgram, topology("commanding: {heartbeat_hz: 50}\n" + kWithPort)});
  ASSERT_TRUE(casd.wait_ready()) << casd.output();
  // A busy machine may hold up some: half a second with 15 of 25 is enough.
  constexpr auto kSpan = std::chrono::milliseconds(500);
  EXPECT_TRUE(wait_until([&] {
    fixture.collect();
    const std::size_t before = fixture.at_fcu.count(mavlink::common::Heartbeat::kId);
    const auto begin = base::steady_now();
    wait_until([&] { return base::steady_now() - begin > kSpan; });
    fixture.collect();
    const auto took = base::steady_now() - begin;
    const auto came = fixture.at_fcu.count(mavlink::common::Heartbeat::kId) - before;
    return base::to_seconds(took) * 30 < static_cast<double>(came);
  })) << fixture.at_fcu.count(mavlink::common::Heartbeat::kId);
}

TEST_F(CasdProgram, RecordsWhereMavlinkRoutersOptionsSay) {
  const auto printed = [&](std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {kCasdProgram, "--as-topology"});
    ChildProcess casd(arguments);
    EXPECT_EQ(casd.wait_exit(), 0) << casd.output();
    return casd.output();
  };
  const std::string text = printed({"-l", "/var/log/x", "-T", "-g", "warning", "-e", "10.0.0.1",
                                    "-e", "10.0.0.1", "/dev/ttyS1"});
  EXPECT_NE(text.find("folder: \"/var/log/x\""), text.npos) << text;
  EXPECT_NE(text.find("tlog: flight"), text.npos) << text;
  EXPECT_NE(text.find("autopilot: {}"), text.npos) << text;
  EXPECT_NE(text.find("10.0.0.1:14550"), text.npos) << text;
  EXPECT_NE(text.find("10.0.0.1:14551"), text.npos) << text;
  EXPECT_NE(printed({"--master", "/dev/ttyS1", "--baudrate", "57600"}).find("baud: 57600"),
            text.npos);
  EXPECT_THAT(ChildProcess({kCasdProgram, "-T", "udp:0"}).end(),
              EndedWith(78, "--telemetry-log needs --log"));
}

TEST(CasdRefuses, AnOptionOfAnotherRouterAndSaysWhatTakesItsPlace) {
  struct RefusedOption {
    const char* name;
    std::vector<std::string> arguments;
    const char* sentence;
  };
  const RefusedOption rows[] = {
      {"ConfFile", {"-c", "main.conf"}, "casd --import FILE"},
      {"ConfFileLong", {"--conf-file", "main.conf"}, "--import"},
      {"ConfDir", {"-d", "/etc/x"}, "--import FILE"},
      {"Sniffer", {"-s", "250"}, "sniffer: true"},
      {"OneDestinationTwice",
       {"-e", "127.0.0.1:14550", "-e", "127.0.0.1:14550"},
       "two endpoints send to 127.0.0.1:14550"},
      {"OneServerTwice",
       {"-p", "127.0.0.1:5760", "tcp:127.0.0.1:5760"},
       "two endpoints send to 127.0.0.1:5760"},
      {"StatsInNoFolder",
       {"--stats", "/nonexistent/x"},
       "/nonexistent/x: cannot be written: No such file or directory"},
      {"StatsAreNoFolder", {"--stats", "/"}, "Is a directory"},
      {"LedgerInNoFolder", {"--ledger", "/nonexistent/x"}, "/nonexistent/x: cannot be written"},
      {"Command", {"--cmd", "arm throttle"}, "'casctl' has a verb"},
      {"HeartbeatDisable", {"--hb-disable"}, "--silent"},
      {"SourceSystem", {"--source-system", "9"}, "system_id"},
      {"Daemon", {"--daemon"}, "systemd"},
      {"Dump", {"--dump"}, "--telemetry-log"}};
  for (const auto& row : rows) {
    SCOPED_TRACE(row.name);
    std::vector<std::string> command{kCasdProgram, "udp:0"};
    const auto& arguments = row.arguments;
    command.insert(command.end(), arguments.begin(), arguments.end());
    EXPECT_THAT(ChildProcess(command).end(), EndedWith(78, row.sentence));
  }
}

TEST_F(CasdProgram, LeavesOutWithAWarningWhatMovesNoPacketOfAnotherRouter) {
  ChildProcess check({kCasdProgram, "--check", "--master", "/dev/ttyACM0,115200", "--out",
                      "127.0.0.1:14550", "--streamrate", "4", "--console", "--map", "--aircraft",
                      "mine", "-r", "-y"});
  ASSERT_EQ(check.wait_exit(), 0) << check.output();
  for (const char* sentence :
       {"'request_rates' of a link", "'casctl monitor'", "'casweb' shows", "'--log FOLDER' records",
        "'casctl status'", "standard error", "the command line: 2 links"}) {
    EXPECT_THAT(check.output(), testing::HasSubstr(sentence));
  }
}

TEST_F(CasdProgram, PrintsEndpointsAndMavlinkRoutersFileAsATopologyThatItTakes) {
  const auto conf = fixture.folder.write(
      "main.conf",
      "[UartEndpoint fc]\nDevice = /dev/ttyS1\nBaud = 57600\n\n[General]\nTcpServerPort = 0\n");
  for (const std::vector<std::string>& arguments :
       {std::vector<std::string>{"--as-topology", "-e", "127.0.0.1:14550", "/dev/ttyS1:57600"},
        std::vector<std::string>{"--import", conf.string()}}) {
    std::vector<std::string> command{kCasdProgram};
    command.insert(command.end(), arguments.begin(), arguments.end());
    ChildProcess print(command);
    ASSERT_EQ(print.wait_exit(), 0) << print.output();
    const auto file = fixture.folder.write("printed.yaml", print.output());
    EXPECT_THAT(ChildProcess({kCasdProgram, "--check", file}).end(),
                EndedWith(0, "/dev/ttyS1 at 57600 baud"));
  }
}

TEST_F(CasdProgram, SaysHowMavlinkRoutersFileIsReadAndThatAnImportStandsAlone) {
  const auto conf = fixture.folder.write("main.conf", "# x\n[General]\nTcpServerPort = 0\n");
  EXPECT_THAT(ChildProcess({kCasdProgram, conf}).end(), EndedWith(78, "casd --import"));
  EXPECT_THAT(ChildProcess({kCasdProgram, "--import", conf, "--check"}).end(),
              EndedWith(78, "prints a topology and ends"));
}

TEST_F(CasdProgram, RunsMavlinkRoutersFileBothWaysAndSaysNothingOfItsOwn) {
  const auto conf = fixture.folder.write(
      "main.conf",
      fixture.expand("[General]\nTcpServerPort = 0\n[UartEndpoint fc]\nDevice = $FCU\n"
                     "Baud = 921600\n[UdpEndpoint gcs]\nMode = Server\nAddress = 127.0.0.1\n"
                     "Port = 0\n"));
  ChildProcess print({kCasdProgram, "--import", conf});
  ASSERT_EQ(print.wait_exit(), 0) << print.output();
  const auto file = fixture.folder.write(
      "imported.yaml", print.output() + "command_port: {port: 0, loopback_without_token: true}\n");
  RunningCasd casd({kCasdProgram, file});
  fixture.sim.set_remote(casd.port("gcs"));
  using namespace mavlink::common;
  Heartbeat ardupilot{.type = MavType::kQuadrotor, .autopilot = MavAutopilot::kArdupilotmega};
  base::rpc::Client client("127.0.0.1:" + std::to_string(casd.port("command_port")));
  EXPECT_TRUE(fixture.collect_until([&] {
    fixture.sim.send(fixture.from_sim(ParamRequestList{}));
    fixture.fcu.write(fixture.from_fcu(ardupilot));
    const auto vehicles = client.call("casd.status", nlohmann::json::object()).at("vehicles");
    return fixture.at_fcu.count(ParamRequestList::kId) > 0 &&
           fixture.at_sim.count(Heartbeat::kId) > 0 && !vehicles.empty() &&
           vehicles[0].at("autopilot") == "ArduPilot";
  })) << casd.output();
  fixture.collect();  // a question would have gone out before that answer
  EXPECT_EQ(fixture.at_fcu.count(Heartbeat::kId), 0U);
  EXPECT_EQ(fixture.at_fcu.count(CommandLong::kId), 0U);
}

TEST_F(CasdProgram, EndsWhenTheCommandPortIsTaken) {
  RunningCasd first({kCasdProgram, topology(kWithPort)});
  const std::string port = std::to_string(first.port("command_port"));
  const auto file = fixture.folder.write(
      "second.yaml", "schema: 1\ncommand_port: {loopback_without_token: true, port: " + port +
                         "}\nlinks:\n  - {name: a, type: udp, local: '127.0.0.1:0'}\n");
  EXPECT_THAT(ChildProcess({kCasdProgram, file}).end(), EndedWith(71, port));
}

TEST(CasdExit, HasItsCodeAndASentence) {
  struct ExitCase {
    const char* name;
    const char* yaml;  // nullptr: no file
    const char* flag;
    int code;
    const char* says;
  };
  const ExitCase rows[] = {
      {"Version", nullptr, "--version", 0, "casd "},
      {"GoodTopology", "schema: 1\nlinks:\n  - {name: a, type: udp, local: '[::1]:0'}\n", "--check",
       0, "1 links"},
      {"EffectiveTopology",
       "schema: 1\nlinks:\n"
       "  - {name: a, type: udp, local: '[::1]:0', accept: nothing, "
       "inject_failures: true}\n"
       "  - {name: b, type: serial, device: /dev/x, baud: 921600, "
       "inject_failures: true}\n"
       "routes:\n  - {from: a, to: b, allow: [HIL_SENSOR]}\n",
       "--check", 0,
       "  a: udp at [::1]:0, read-only\n"
       "  b: serial /dev/x at 921600 baud, paced, may inject failures\n"
       "to vehicles not in HIL\n"
       "  all: b\n"
       "routes\n"
       "  a -> b: only HIL_SENSOR\n"
       "expected load of the lines\n"
       "  b: "},
      {"MissingKey",
       "schema: 1\nlinks:\n  - {name: a, type: udp, local: '[::1]:0', "
       "signing: {key_file: none.key}}\n",
       "--check", 78, "none.key"},
      {"UnprintableDevice",
       "schema: 1\nlinks:\n  - {name: a, type: serial, device: \"/dev/x\\e[31m\"}\n", "--check", 0,
       "/dev/x?[31m"},
      {"UnprintableType", "schema: 1\nlinks:\n  - {name: a, type: \"x\\e[31m\\u202e\"}\n",
       "--check", 78, "'x?[31m?' is none of"},
      {"MissingFile", nullptr, "--check", 78, "topology.yaml"},
      {"FileAndEndpoint", "schema: 1\nlinks: []\n", "udp:14550", 78, "is not an endpoint"},
      {"UnknownFlag", nullptr, "--frobnicate", 78, "frobnicate"},
      {"MisspeltKey", "schema: 1\nlinks:\n  - {name: a, type: udp, locall: 'x:1'}\n", "--check", 78,
       "topology.yaml:3"}};
  for (const auto& test : rows) {
    SCOPED_TRACE(test.name);
    TemporaryFolder folder;
    const std::string file = folder / "topology.yaml";
    if (test.yaml != nullptr) folder.write("topology.yaml", test.yaml);
    EXPECT_THAT(ChildProcess({kCasdProgram, file, test.flag}).end(),
                EndedWith(test.code, test.says));
  }
}

}  // namespace
}  // namespace cas::test
