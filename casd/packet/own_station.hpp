// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "mavlink_gen/runtime/packet.hpp"

namespace cas::casd {

/// casd's own ids, unless its topology has others. Ground stations use 255/190.
inline constexpr mav::Source kOwnStation{.system = 254, .component = 190};

}  // namespace cas::casd
