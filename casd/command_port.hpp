// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "base/clock.hpp"
#include "casd/link_id.hpp"
#include "casd/station.hpp"
#include "casd/topology.hpp"

namespace boost::asio {
class io_context;
}

namespace cas::casd {

class Monitor;
class VehicleCommander;

/// What the command port needs from the rest of casd. Functions are called on the thread of `io`;
/// empty ones leave their methods out.
struct CommandPortNeeds {
  boost::asio::io_context* io = nullptr;
  const Monitor* monitor = nullptr;
  /// The topology in force; it changes on a reload.
  std::function<const Topology&()> topology;
  std::function<base::RunTime()> now;
  /// Sends a packet of casd's own station.
  SendPacket send;
  /// Starts a telemetry log. @throws base::ConfigError
  std::function<void(const std::filesystem::path&)> start_log;
  std::function<void()> stop_log;
  /// Reads the topology again. @throws base::ConfigError, then the old one stays in force
  std::function<void()> reload;
};

/// The command port with all that stands behind it: JSON-RPC server, commander, figures.
/// Lives on the thread of `io`.
class CommandPort {
 public:
  /// Reads the gain map: the topology's, else the shipped one. @throws base::ConfigError
  explicit CommandPort(CommandPortNeeds needs);
  ~CommandPort();

  /// casd's own station, for the switchboard to feed.
  Station& station();
  const VehicleCommander& commander() const;
  /// Opens the sockets that the topology asks for. @return the bound TCP port
  /// @throws base::ConfigError
  std::uint16_t listen();
  /// Once a second, after Monitor::sample: tells subscribers.
  void publish();
  /// casd.status as JSON text, for --stats FILE.
  std::string stats() const;
  /// Ends all connections.
  void close();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cas::casd
