// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace cas::test {

/// The baud rate that a terminal is set to; of a pseudo-terminal's master, its other end's.
unsigned line_rate(int fd);

}  // namespace cas::test
