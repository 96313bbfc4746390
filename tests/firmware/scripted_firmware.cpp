// SPDX-License-Identifier: BSD-3-Clause
// The scripted peers as programs, for hils and for trying things by hand.
//
//   scripted_firmware px4-sitl PORT LOCAL REMOTE [WORD [OTHER]]
//                                     simulator's TCP port; UDP ports of the ground station's link;
//                                     see px4_options(); UDP port for a station that casd does not
//                                     hear: the answers to it go over the other link, too
//                                     -i N behind WORD: PORT and LOCAL are lists, '4001,4002', and
//                                     the N-th from 0 counts
//                                     keeps its parameters in the file `parameters` of its folder,
//                                     unless WORD is `forgetful`
//   scripted_firmware px4-hitl TTY
//   scripted_firmware ardupilot PORT REMOTE [WORD]        simulator's UDP port, a list with -i N;
//                                     ground station's
#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <termios.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <string>
#include <utility>

#include "tests/firmware/scripted_ardupilot.hpp"
#include "tests/firmware/scripted_px4.hpp"

namespace cas::test {
namespace {

sockaddr_in loopback(int port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  return address;
}

int receive_udp(int local) {
  const int fd = ::socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK, 0);
  const sockaddr_in here = loopback(local);
  if (::bind(fd, reinterpret_cast<const sockaddr*>(&here), sizeof here) != 0) std::perror("bind");
  return fd;
}

/// A UDP socket that sends to one port of this machine.
int open_udp(int local, int remote) {
  const int fd = receive_udp(local);
  const sockaddr_in there = loopback(remote);
  ::connect(fd, reinterpret_cast<const sockaddr*>(&there), sizeof there);
  return fd;
}

int connect_tcp(int port) {
  const sockaddr_in there = loopback(port);
  for (;;) {
    const int fd = ::socket(AF_INET, SOCK_STREAM, 0);
    if (::connect(fd, reinterpret_cast<const sockaddr*>(&there), sizeof there) == 0) {
      const int on = 1;
      setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
      return fd;
    }
    ::close(fd);
    ::poll(nullptr, 0, 100);
  }
}

Channel::Send to(int fd) {
  return [fd](std::span<const std::uint8_t> bytes) {
    [[maybe_unused]] const auto gone = ::write(fd, bytes.data(), bytes.size());
  };
}

using Buffer = std::array<std::uint8_t, 4096>;

std::span<const std::uint8_t> read_from(int fd, Buffer& buffer) {
  const ssize_t size = ::read(fd, buffer.data(), buffer.size());
  return std::span(buffer).first(size > 0 ? static_cast<std::size_t>(size) : 0);
}

/// Takes its fence's parameters, and never acts at it; acts, and says nothing of it.
FenceManner fence_manner(const std::string& word) {
  if (word == "unfenced") return FenceManner::kNeverActs;
  return word == "mute" ? FenceManner::kSaysNothing : FenceManner::kKeeps;
}

/// How a PX4 in software is to behave.
ScriptedPx4::Options px4_options(const std::string& word) {
  using std::chrono::seconds;
  constexpr base::RunTime kNever{std::chrono::hours(10)};
  constexpr base::Duration kLong = std::chrono::hours(10);
  // Refuses to take off at first, and disarms itself.
  if (word == "early") return {.takes_off_after = base::RunTime(seconds(15))};
  // See fence_manner().
  if (word == "unfenced" || word == "mute") return {.fence = fence_manner(word)};
  // Ignores setpoints from 4 s after the first on.
  if (word == "deaf") return {.loses_setpoints_after = seconds(4)};
  // Reports flights that it has not flown.
  if (word == "skips-waypoints") return {.lie = Px4Lie::kSkipsWaypoints};
  if (word == "ignores-setpoints") return {.lie = Px4Lie::kIgnoresSetpoints};
  if (word == "lands-in-words") return {.lie = Px4Lie::kLandsInWords};
  if (word == "returns-in-words") return {.lie = Px4Lie::kReturnsInWords};
  if (word == "dies") return {.dies_after = seconds(4)};
  if (word == "plane") return {.is_plane = true};
  if (word == "ardupilot") return {.is_ardupilot = true};
  // Accepts its first takeoff in vain, and disarms itself.
  if (word == "idle") return {.stays_at_first = true};
  // Refuses to take off, and stays armed until it is disarmed.
  if (word == "stubborn") return {.takes_off_after = kNever, .disarms_itself_after = kLong};
  return {};
}

/// The N-th number of a list, "4001,4002"; of one number that one.
int nth(std::string list, int n) {
  for (; n > 0; --n) list.erase(0, list.find(',') + 1);
  return std::atoi(list.c_str());
}

/// Takes `-i N` off the end of a command line. @return N
int take_instance(int& argc, char** argv) {
  if (argc < 3 || std::string(argv[argc - 2]) != "-i") return 0;
  argc -= 2;
  return std::atoi(argv[argc + 1]);
}

constexpr const char* kParamFile = "parameters";

std::string read_params() {
  std::stringstream text;
  text << std::ifstream(kParamFile).rdbuf();
  return text.str();
}

void keep_params(const ScriptedPx4& px4) {
  std::ofstream(kParamFile) << px4.controller().params_text();
}

/// @param other  UDP port for a second station; 0: none
int px4_sitl(int port, int local, int remote, const std::string& word, int other, int instance) {
  const int ground = open_udp(local, remote);
  const int second = other == 0 ? -1 : receive_udp(other);
  const int simulator = connect_tcp(port);
  ScriptedPx4::Options options = px4_options(word);
  options.system = static_cast<std::uint8_t>(instance + 1);
  ScriptedPx4 px4(options, to(simulator), to(ground));
  if (word != "forgetful") px4.restore_params(read_params());
  std::uint64_t kept = px4.controller().params_revision();
  px4.on_connected();
  Buffer buffer;
  for (;;) {
    std::array<pollfd, 3> ends{{{simulator, POLLIN, 0}, {ground, POLLIN, 0}, {second, POLLIN, 0}}};
    ::poll(ends.data(), ends.size(), 1000);
    if (ends[0].revents != 0) {
      const auto bytes = read_from(simulator, buffer);
      if (bytes.empty()) return 0;
      px4.on_simulator_bytes(bytes, px4.clock());
    }
    if (ends[1].revents != 0) px4.on_ground_bytes(read_from(ground, buffer), px4.clock());
    if (ends[2].revents != 0) px4.on_ground_bytes(read_from(second, buffer), px4.clock());
    if (std::exchange(kept, px4.controller().params_revision()) != kept) keep_params(px4);
  }
}

int px4_hitl(const char* tty) {
  const int line = ::open(tty, O_RDWR | O_NOCTTY | O_NONBLOCK);
  if (line < 0) return std::perror(tty), 1;
  termios settings{};
  ::tcgetattr(line, &settings);
  ::cfmakeraw(&settings);
  ::tcsetattr(line, TCSANOW, &settings);
  ScriptedPx4 px4({.mode = Px4Mode::kHitl}, to(line), to(line));
  const base::RunTime boot = base::steady_now();
  Buffer buffer;
  for (;;) {
    pollfd end{line, POLLIN, 0};
    ::poll(&end, 1, 1);
    const base::RunTime now(base::steady_now() - boot);
    if (end.revents != 0) px4.on_ground_bytes(read_from(line, buffer), now);
    px4.tick(now);
  }
}

int ardupilot(int port, int remote, const std::string& word, int instance) {
  const int ground = open_udp(0, remote);
  const int simulator = open_udp(0, port);
  ScriptedArdupilot firmware(
      {.system = static_cast<std::uint8_t>(instance + 1), .fence = fence_manner(word)}, to(ground));
  Buffer buffer;
  for (;;) {
    to(simulator)(firmware.servo_packet());
    pollfd end{simulator, POLLIN, 0};
    if (::poll(&end, 1, 1000) > 0) {
      const auto bytes = read_from(simulator, buffer);
      firmware.on_text({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
    }
    for (auto bytes = read_from(ground, buffer); !bytes.empty();
         bytes = read_from(ground, buffer)) {
      firmware.on_ground_bytes(bytes);
    }
  }
}

}  // namespace
}  // namespace cas::test

int main(int argc, char** argv) {
  using namespace cas::test;
  const int instance = take_instance(argc, argv);
  const std::string kind = argc > 1 ? argv[1] : "";
  const auto number = [&](int i) { return std::atoi(argv[i]); };
  if (kind == "px4-sitl" && argc >= 5 && argc <= 7) {
    return px4_sitl(nth(argv[2], instance), nth(argv[3], instance), number(4),
                    argc > 5 ? argv[5] : "", argc > 6 ? number(6) : 0, instance);
  }
  if (kind == "px4-hitl" && argc == 3) return px4_hitl(argv[2]);
  if (kind == "ardupilot" && (argc == 4 || argc == 5)) {
    return ardupilot(nth(argv[2], instance), number(3), argc > 4 ? argv[4] : "", instance);
  }
  std::fprintf(stderr, "scripted_firmware px4-sitl|px4-hitl|ardupilot ...\n");
  return 2;
}
