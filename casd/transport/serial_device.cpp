// SPDX-License-Identifier: BSD-3-Clause
#include "casd/transport/serial_device.hpp"

// asm/termbits.h has termios2 (any baud rate) and clashes with <termios.h>: no termios call here.
#include <asm/termbits.h>
#include <fcntl.h>
#include <linux/serial.h>
#include <sys/file.h>
#include <sys/ioctl.h>

#include <cerrno>

#include "base/error.hpp"
#include "base/os/pty_lock.hpp"
#include "casd/link/link_core.hpp"
#include "casd/transport/pty_admission.hpp"

namespace cas::casd {
namespace {

void put_baud(termios2& settings, unsigned baud) {
  settings.c_cflag &= ~static_cast<tcflag_t>(CBAUD | (CBAUD << IBSHIFT));
  settings.c_cflag |= BOTHER | (BOTHER << IBSHIFT);
  settings.c_ispeed = settings.c_ospeed = baud;
}

bool make_raw(int fd, const SerialOptions& options) {
  termios2 settings{};
  if (::ioctl(fd, TCGETS2, &settings) != 0) return false;
  settings.c_iflag &= ~static_cast<tcflag_t>(IGNBRK | BRKINT | PARMRK | ISTRIP | INLCR | IGNCR |
                                             ICRNL | IXON | IXOFF | IXANY);
  settings.c_oflag &= ~static_cast<tcflag_t>(OPOST);
  settings.c_lflag &= ~static_cast<tcflag_t>(ECHO | ECHONL | ICANON | ISIG | IEXTEN);
  settings.c_cflag &= ~static_cast<tcflag_t>(CSIZE | PARENB | CSTOPB | HUPCL | CRTSCTS);
  settings.c_cflag |= CS8 | CREAD | CLOCAL;
  if (options.flow_control) settings.c_cflag |= CRTSCTS;
  if (options.baud > 0) put_baud(settings, options.baud);
  settings.c_cc[VMIN] = 1;  // with 0 an empty line reads like one that was hung up
  settings.c_cc[VTIME] = 0;
  return ::ioctl(fd, TCSETS2, &settings) == 0;
}

// USB adapters hold received bytes back for up to 16 ms otherwise. Not every driver knows it.
void ask_low_latency(int fd) {
  serial_struct settings{};
  if (::ioctl(fd, TIOCGSERIAL, &settings) != 0) return;
  settings.flags |= ASYNC_LOW_LATENCY;
  ::ioctl(fd, TIOCSSERIAL, &settings);
}

}  // namespace

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
  if (!make_raw(line.get(), options)) return failed("not a terminal: ");
  ask_low_latency(line.get());
  ::ioctl(line.get(), TCFLSH, TCIOFLUSH);
  return line;
}

bool set_baud(int line, unsigned baud) {
  termios2 settings{};
  if (::ioctl(line, TCGETS2, &settings) != 0) return false;
  put_baud(settings, baud);
  if (::ioctl(line, TCSETS2, &settings) != 0) return false;
  ::ioctl(line, TCFLSH, TCIFLUSH);
  return true;
}

}  // namespace cas::casd
