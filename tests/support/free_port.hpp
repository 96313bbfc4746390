// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

namespace cas::test {

/// A port of 127.0.0.1, for UDP and TCP, for a program that cannot be given port 0 because another
/// one must know the number before it starts. It was free when asked, lies outside the range from
/// which the kernel hands out ports, and no other test on this machine is given it while this
/// process lives.
std::uint16_t free_port();

}  // namespace cas::test
