// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "base/os/descriptor.hpp"
#include "hils/timing/line_probe.hpp"

namespace cas::hils {

/// Measures an open serial line. @return false: it went away meanwhile
bool run_probe(const base::Descriptor& line, LineProbe& probe);

}  // namespace cas::hils
