// SPDX-License-Identifier: BSD-3-Clause
// Any bytes as an MCAP file: a ConfigError, or its contents for the page.
#include <cstdint>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <string_view>

#include "base/error.hpp"
#include "hils/replay/mcap_contents.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  try {
    const auto record = cas::hils::mcap_contents(bytes, "fuzz");
    if (record["vehicles"].empty()) std::abort();
  } catch (const cas::base::ConfigError&) {
  }
  return 0;
}
