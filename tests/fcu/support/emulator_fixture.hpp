// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/earth/geodesy.hpp"
#include "base/random.hpp"
#include "base/rpc/client.hpp"
#include "mavlink/common/command_ack.hpp"
#include "mavlink/common/command_long.hpp"
#include "mavlink/common/ping.hpp"
#include "mavlink_gen/runtime/codec.hpp"
#include "tests/support/child_process.hpp"
#include "tests/support/packet_stream.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::fcu::test {

/// The program fcu_emulator on a pseudo-terminal of its own, with a ground station (255/190) and a
/// simulator (1/200) at the other end of the line: both are this object.
class EmulatorFixture {
 public:
  /// @param config  further lines of the configuration file
  explicit EmulatorFixture(const std::string& config = "");
  ~EmulatorFixture();
  EmulatorFixture(const EmulatorFixture&) = delete;
  EmulatorFixture& operator=(const EmulatorFixture&) = delete;

  // Towards the controller.
  void send_bytes(std::span<const std::uint8_t> bytes);
  template <class Message>
  void send(const Message& message, int version = 2, mav::Source from = {255, 190}) {
    std::array<std::uint8_t, mav::kMaxPacketBytes> buffer{};
    const std::size_t size = version == 1 ? mav::encode_v1(message, from, sequence_++, buffer)
                                          : mav::encode(message, from, sequence_++, buffer);
    send_bytes(std::span(buffer).first(size));
  }
  mavlink::common::CommandLong command(mavlink::common::MavCmd id,
                                       std::array<float, 7> params = {}) const;
  /// Sends a COMMAND_LONG. @return its result, the first one
  std::optional<mavlink::common::MavResult> result(mavlink::common::MavCmd id,
                                                   std::array<float, 7> params = {});
  /// Sends sensors of a vehicle at rest, as fast as the controller handles them.
  void stand_still(double seconds);
  /// Sends sensors at rest until the controller may be armed.
  void settle();

  /// From the controller. Reads all waiting input. @return whether there was any
  bool read();
  /// The next packet of this message that meets the condition; earlier ones are dropped.
  template <class Message>
  std::optional<Message> next(const std::function<bool(const Message&)>& condition = {},
                              const std::function<void(const mav::PacketView&)>& dropped = {},
                              base::Duration patience = cas::test::kPatience) {
    std::optional<Message> found;
    cas::test::wait_until(
        [&] {
          read();
          auto& packets = stream_.packets();
          while (!found && !packets.empty()) {
            const auto message = mav::decode<Message>(packets.front().view());
            if (message && (!condition || condition(*message))) {
              found = message;
              version_ = packets.front().view().version;
              source_ = packets.front().source;
            } else if (dropped) {
              dropped(packets.front().view());
            }
            packets.pop_front();
          }
          return found.has_value();
        },
        patience);
    return found;
  }
  /// MAVLink version and sender of the packet that next() gave last.
  int version() const { return version_; }
  mav::Source source() const { return source_; }
  std::uint64_t garbage() const { return stream_.garbage(); }
  /// Waits for the answer to a PING: all that was sent before has then been dealt with.
  /// @return packets of this message that came until then
  template <class Message>
  std::vector<Message> until_ping() {
    mavlink::common::Ping ping;
    ping.seq = ++pings_;
    send(ping);
    std::vector<Message> out;
    next<mavlink::common::Ping>([&](const auto& m) { return m.seq == ping.seq; },
                                [&](const auto& packet) {
                                  if (const auto m = mav::decode<Message>(packet))
                                    out.push_back(*m);
                                });
    return out;
  }
  /// Drops all packets so far.
  void forget();

  /// Calls a method of the control socket.
  base::rpc::Json call(const std::string& method, const base::rpc::Json& params);
  base::rpc::Json call(const std::string& method);
  /// Reopens the terminal after a hang-up. @return whether it is there
  bool reopen();
  bool hung_up() const { return hung_up_; }
  cas::test::ChildProcess& process() { return *process_; }
  void restart();
  /// The symlink that the terminal is offered under.
  const std::filesystem::path& link() const { return link_; }
  std::filesystem::path config_file() const { return folder_ / "fcu.yaml"; }
  std::filesystem::path control_socket() const { return folder_ / "control"; }
  std::filesystem::path params_file() const { return folder_ / "params"; }
  const base::Geodetic& home() const { return home_; }

 private:
  void start();
  void open();
  void keep_up();

  cas::test::TemporaryFolder folder_;
  std::filesystem::path link_;
  std::unique_ptr<cas::test::ChildProcess> process_;
  base::Geodetic home_{47.397742, 8.545594, 488.0};
  base::NormalRandom random_{7};
  std::uint64_t sensor_usec_ = 1'000'000;
  int fd_ = -1;
  bool hung_up_ = false;
  cas::test::PacketStream stream_;
  std::uint8_t sequence_ = 0;
  std::uint32_t pings_ = 0;
  int version_ = 0;
  mav::Source source_;
};

}  // namespace cas::fcu::test
