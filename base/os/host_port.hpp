// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace cas::base {

/// The two halves of "HOST:PORT"; an IPv6 address without its brackets.
struct HostPort {
  std::string host;
  std::string port;
};

/// Takes "127.0.0.1:14560", "host:14560" or "[::1]:14560" apart; neither half is looked up.
/// @return nullopt when a half or a bracket is missing
inline std::optional<HostPort> parse_host_port(std::string_view text) {
  const std::size_t colon = text.rfind(':');
  if (colon == std::string_view::npos || colon + 1 == text.size()) return std::nullopt;
  std::string_view host = text.substr(0, colon);
  if (host.starts_with('[') || host.ends_with(']')) {
    if (host.size() < 2 || host.front() != '[' || host.back() != ']') return std::nullopt;
    host = host.substr(1, host.size() - 2);
  }
  if (host.empty()) return std::nullopt;
  return HostPort{std::string(host), std::string(text.substr(colon + 1))};
}

}  // namespace cas::base
