// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace cas::web {

/// Decides which browser requests are answered. A page of another origin can make a browser send
/// requests here: `Origin` gives it away. A foreign name that resolves to this machine (DNS
/// rebinding) shows in `Host`. Pure.
class AccessRules {
 public:
  /// @param names  further names that the page is reached by, beside those of this machine
  AccessRules(std::uint16_t port, const std::vector<std::string>& names);

  /// Whether a request names us: "127.0.0.1:5791", exactly, but for upper and lower case.
  bool allows_host(std::string_view host) const;
  /// Whether a WebSocket comes from our own page: `origin` is http:// and the request's Host.
  bool allows_origin(std::string_view origin, std::string_view host) const;

 private:
  std::vector<std::string> hosts_;
};

}  // namespace cas::web
