// SPDX-License-Identifier: BSD-3-Clause
#include "base/os/cpu_latency.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <string>

#include "base/error.hpp"
#include "base/os/log.hpp"

namespace cas::base {

CpuLatencyRequest::CpuLatencyRequest(std::optional<int> most_us,
                                     const std::filesystem::path& device) {
  if (!most_us) return;
  Descriptor opened(::open(device.c_str(), O_WRONLY | O_CLOEXEC));
  const std::int32_t value = *most_us;
  if (!opened || ::write(opened.get(), &value, sizeof value) != sizeof value) {
    log::warn("idle processors may sleep, " + device.string() + ": " + error_text(errno));
    return;
  }
  device_ = std::move(opened);
}

}  // namespace cas::base
