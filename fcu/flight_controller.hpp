// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "base/measure/histogram.hpp"
#include "base/time/clock.hpp"
#include "fcu/core/fcu_config.hpp"
#include "fcu/core/outbox.hpp"
#include "fcu/flight/flight_status.hpp"

namespace cas::mav {
struct PacketView;
namespace services {
class FtpStore;
}
}  // namespace cas::mav

namespace cas::fcu {

class Estimator;
class ParamStore;

/// Counts of one flight controller.
struct FlightControllerStats {
  std::map<std::string, std::uint64_t, std::less<>> received;  ///< by message name
  std::map<std::string, std::uint64_t, std::less<>> sent;
  std::uint64_t crc_errors = 0;
  std::uint64_t sequence_gaps = 0;  ///< packets of its senders that did not come: lost or filtered
  std::uint64_t stale_sensors = 0;  ///< HIL_SENSOR whose time went back or stood still
  std::uint64_t missed_controls = 0;  ///< control periods that no HIL_SENSOR fell into
  base::Histogram sensor_age;         ///< arrival minus own stamp, relative to the smallest seen
};

/// A flight controller without I/O and without a clock: bytes and time in, packets out.
///
///   on_packet: HIL_SENSOR --> estimator --> (400 Hz on the sensor's clock) control -->
///   HIL_CONTROLS
///              others     --> command, parameter, mission protocol, setpoints
///   tick:      streams, heartbeat, time-outs, failsafes
///
/// Flies on HIL_SENSOR and HIL_GPS alone. Not for use from several threads at once.
class FlightController {
 public:
  FlightController(const FcuConfig& config, PacketSink send);
  ~FlightController();
  FlightController(FlightController&&) noexcept;
  FlightController& operator=(FlightController&&) noexcept;

  /// Bytes off the line; finds the packets in them and calls on_packet for each.
  void on_bytes(std::span<const std::uint8_t> bytes, base::RunTime now);
  /// The same, with the time of each packet from `now_of`: in lockstep the stream's.
  using PacketClock = std::function<base::RunTime(const mav::PacketView&)>;
  void on_bytes(std::span<const std::uint8_t> bytes, const PacketClock& now_of);
  /// One intact packet.
  void on_packet(const mav::PacketView& packet, base::RunTime now);
  /// Runs everything that time alone makes due. Each HIL_SENSOR does it too (in lockstep each that
  /// is answered); call it at least every 20 ms for the time when none come.
  void tick(base::RunTime now);

  void set_hil_observer(HilObserver observer);
  /// Serves these files too, as the folder `files`. @param files  outlive this controller
  void serve(mav::services::FtpStore& files);

  const FlightStatus& status() const;
  const Estimator& estimator() const;
  /// Copies the counts (not for every step).
  FlightControllerStats stats() const;

  const ParamStore& params() const;
  /// Sets a parameter as PARAM_SET would. @return false when unknown or out of range
  bool set_param(std::string_view name, double value);
  /// All parameters that differ from those of the configuration, as "NAME VALUE" lines.
  std::string params_text() const;
  /// Whether a reboot was asked for since the last call; the shell makes a new controller.
  bool take_reboot_request();
  /// Counts up at each change of a parameter, so that a shell knows when to save.
  std::uint64_t params_revision() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cas::fcu
