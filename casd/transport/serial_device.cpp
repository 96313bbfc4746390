// SPDX-License-Identifier: BSD-3-Clause
#include "casd/transport/serial_device.hpp"

#include <fcntl.h>
#include <sys/file.h>

#include <cerrno>

#include "base/error.hpp"
#include "base/os/pty_lock.hpp"
#include "base/os/serial_settings.hpp"
#include "casd/link/link_core.hpp"
#include "casd/transport/pty_admission.hpp"

namespace cas::casd {

base::Descriptor open_serial(const std::string& device, const SerialOptions& options,
                             SerialRefusal& refusal) {
  const auto failed = [&](const char* what) {
    refusal.sentence = device + ": " + what + base::error_text(errno);
    return base::Descriptor();
  };
  base::Descriptor line(::open(device.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC));
  if (!line) {
    failed("");
    if (errno == EPERM)
      refusal.sentence += ": a service may open the devices of its DeviceAllow alone";
    if (errno == EACCES) refusal.sentence += ": casd's user is not in the device's group (dialout)";
    return {};
  }
  if (base::identify_pty(line.get())) {
    if (auto sentence = pty_refusal(line.get(), device, options.unlocked_pty)) {
      refusal.sentence = std::move(*sentence);
      return {};
    }
  }
  if (::flock(line.get(), LOCK_EX | LOCK_NB) != 0) {
    refusal.in_use = errno == EWOULDBLOCK;
    return failed("in use: ");
  }
  if (!base::make_serial_raw(line.get(), options.baud, options.flow_control)) {
    return failed("not a terminal: ");
  }
  base::ask_serial_low_latency(line.get());
  base::flush_serial(line.get());
  return line;
}

}  // namespace cas::casd
