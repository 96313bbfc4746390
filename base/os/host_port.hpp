// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>

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

/// Whether it may be the name or address of a host: no blanks, no # of a comment, no part of a URL.
inline bool is_host_text(std::string_view host) {
  const auto fits = [](char c) {
    return static_cast<unsigned char>(c) > ' ' && c != '\x7F' && c != '#' && c != '/' && c != '@';
  };
  return !host.empty() && std::ranges::all_of(host, fits);
}

/// The number of a port in digits. @return nullopt: it is none of 0 to 65535
inline std::optional<std::uint16_t> parse_port(std::string_view digits) {
  std::uint16_t port = 0;
  const char* const end = digits.data() + digits.size();
  const auto [stop, error] = std::from_chars(digits.data(), end, port);
  if (error != std::errc{} || stop != end) return std::nullopt;
  return port;
}

}  // namespace cas::base
