// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace router_load {

/// Reads the command line into `o`. @return false with a word on standard error
bool parse_options(int argc, char** argv);

}  // namespace router_load
