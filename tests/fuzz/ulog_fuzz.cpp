// SPDX-License-Identifier: BSD-3-Clause
// Any bytes as a vehicle's log: a ConfigError, or its contents for the page.
#include <cstdint>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <string_view>

#include "base/error.hpp"
#include "hils/replay/ulog_messages.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  try {
    constexpr std::size_t kNumbers = 1000;
    const auto vehicle = cas::hils::ulog_messages(bytes, kNumbers);
    if (vehicle["log"]["messages"].empty()) std::abort();
  } catch (const cas::base::ConfigError&) {
  }
  return 0;
}
