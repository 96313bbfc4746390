// SPDX-License-Identifier: BSD-3-Clause
// Any bytes as the record of a run: a ConfigError, or gzip of a bounded size.
#include <cstdint>
#include <string_view>

#include "base/error.hpp"
#include "hils/replay/replay_page.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    cas::hils::check_gzip({reinterpret_cast<const char*>(data), size});
  } catch (const cas::base::ConfigError&) {
  }
  return 0;
}
