// SPDX-License-Identifier: BSD-3-Clause
#include "tests/support/line_rate.hpp"

// asm/termbits.h has termios2 (any baud rate) and clashes with <termios.h>.
#include <asm/termbits.h>
#include <sys/ioctl.h>

namespace cas::test {

unsigned line_rate(int fd) {
  termios2 settings{};
  ::ioctl(fd, TCGETS2, &settings);
  return settings.c_ospeed;
}

}  // namespace cas::test
