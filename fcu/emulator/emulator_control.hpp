// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "base/measure/histogram.hpp"
#include "base/time/clock.hpp"
#include "fcu/flight_controller.hpp"
#include "fcu/line/line_model.hpp"

namespace boost::asio {
class io_context;
}

namespace cas::fcu {

/// The emulator as the control socket sees it.
class EmulatorView {
 public:
  virtual ~EmulatorView() = default;
  virtual FlightController& controller() = 0;
  virtual EmulatorLine& serial_line() = 0;
  /// Time spent on the bytes of one read: a HIL_SENSOR as a rule.
  virtual const base::Histogram& update_time() const = 0;
  virtual void hang_up(base::Duration length) = 0;
  virtual std::string endpoints() const = 0;
};

/// JSON-RPC methods fcu.status, fcu.stats, line.set, line.hangup on a Unix socket.
class EmulatorControl {
 public:
  /// @throws base::ConfigError
  EmulatorControl(boost::asio::io_context& io, EmulatorView& view,
                  const std::filesystem::path& socket);
  ~EmulatorControl();
  /// Waits for clients anew, after a handler has lacked memory.
  void begin();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// The figures of fcu.stats as a file. @throws base::ConfigError
void write_stats(const std::filesystem::path& file, EmulatorView& view);

}  // namespace cas::fcu
