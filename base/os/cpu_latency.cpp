// SPDX-License-Identifier: BSD-3-Clause
#include "base/os/cpu_latency.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <string>
#include <system_error>

#include "base/config/config_whole.hpp"
#include "base/os/log.hpp"

namespace cas::base {

CpuLatencyRequest::CpuLatencyRequest(std::optional<int> most_us,
                                     const std::filesystem::path& device) {
  if (!most_us) return;
  Descriptor opened(::open(device.c_str(), O_WRONLY | O_CLOEXEC));
  const std::int32_t value = *most_us;
  if (!opened || ::write(opened.get(), &value, sizeof value) != sizeof value) {
    log::warn("idle processors may sleep, " + device.string() + ": " +
              std::generic_category().message(errno));
    return;
  }
  device_ = std::move(opened);
}

std::optional<int> parse_cpu_latency(const ConfigNode& node) {
  const auto key = node.find("cpu_dma_latency_us");
  if (!key) return std::nullopt;
  return static_cast<int>(whole_in(*key, 0, CpuLatencyRequest::kLongest_us));
}

}  // namespace cas::base
