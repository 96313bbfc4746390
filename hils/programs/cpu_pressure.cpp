// SPDX-License-Identifier: BSD-3-Clause
#include "hils/programs/cpu_pressure.hpp"

#include <charconv>
#include <chrono>
#include <fstream>
#include <string>

namespace cas::hils {

namespace {

std::optional<base::Duration> read_cpu_pressure() {
  std::ifstream in("/proc/pressure/cpu");
  std::string line;
  if (!std::getline(in, line)) return std::nullopt;
  return parse_cpu_pressure(line);
}

}  // namespace

std::optional<base::Duration> parse_cpu_pressure(std::string_view text) {
  constexpr std::string_view kTotal = "total=";
  if (!text.starts_with("some ")) return std::nullopt;
  const std::size_t at = text.find(kTotal);
  if (at == std::string_view::npos) return std::nullopt;
  const char* first = text.data() + at + kTotal.size();
  std::int64_t microseconds = 0;
  const auto [end, error] = std::from_chars(first, text.data() + text.size(), microseconds);
  if (error != std::errc{}) return std::nullopt;
  return std::chrono::microseconds(microseconds);
}

void CpuPressure::start() {
  waited_before_ = read_cpu_pressure();
  began_ = base::steady_now();
}

void CpuPressure::stop() {
  const std::optional<base::Duration> waited = read_cpu_pressure();
  const base::Duration passed = base::steady_now() - began_;
  if (!waited || !waited_before_ || passed <= base::Duration::zero()) return;
  share_ = base::to_seconds(*waited - *waited_before_) / base::to_seconds(passed);
}

}  // namespace cas::hils
