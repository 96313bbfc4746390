// SPDX-License-Identifier: BSD-3-Clause
#include "base/os/serial_settings.hpp"

// asm/termbits.h has termios2 (any baud rate) and clashes with <termios.h>: no termios call here.
#include <asm/termbits.h>
#include <linux/serial.h>
#include <sys/ioctl.h>

namespace cas::base {
namespace {

void put_baud(termios2& settings, unsigned baud) {
  settings.c_cflag &= ~static_cast<tcflag_t>(CBAUD | (CBAUD << IBSHIFT));
  settings.c_cflag |= BOTHER | (BOTHER << IBSHIFT);
  settings.c_ispeed = settings.c_ospeed = baud;
}

}  // namespace

bool make_serial_raw(int fd, unsigned baud, bool flow_control) {
  termios2 settings{};
  if (::ioctl(fd, TCGETS2, &settings) != 0) return false;
  settings.c_iflag &= ~static_cast<tcflag_t>(IGNBRK | BRKINT | PARMRK | ISTRIP | INLCR | IGNCR |
                                             ICRNL | IXON | IXOFF | IXANY);
  settings.c_oflag &= ~static_cast<tcflag_t>(OPOST);
  settings.c_lflag &= ~static_cast<tcflag_t>(ECHO | ECHONL | ICANON | ISIG | IEXTEN);
  settings.c_cflag &= ~static_cast<tcflag_t>(CSIZE | PARENB | CSTOPB | HUPCL | CRTSCTS);
  settings.c_cflag |= CS8 | CREAD | CLOCAL;
  if (flow_control) settings.c_cflag |= CRTSCTS;
  if (baud > 0) put_baud(settings, baud);
  settings.c_cc[VMIN] = 1;  // with 0 an empty line reads like one that was hung up
  settings.c_cc[VTIME] = 0;
  return ::ioctl(fd, TCSETS2, &settings) == 0;
}

void ask_serial_low_latency(int fd) {
  serial_struct settings{};
  if (::ioctl(fd, TIOCGSERIAL, &settings) != 0) return;
  settings.flags |= ASYNC_LOW_LATENCY;
  ::ioctl(fd, TIOCSSERIAL, &settings);
}

void flush_serial(int fd) { ::ioctl(fd, TCFLSH, TCIOFLUSH); }

bool set_serial_baud(int fd, unsigned baud) {
  termios2 settings{};
  if (::ioctl(fd, TCGETS2, &settings) != 0) return false;
  put_baud(settings, baud);
  if (::ioctl(fd, TCSETS2, &settings) != 0) return false;
  ::ioctl(fd, TCFLSH, TCIFLUSH);
  return true;
}

}  // namespace cas::base
