// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace cas::web {

/// Which requests of a browser are ours to answer. A page of another origin can make a browser send
/// requests here: `Origin` tells it from ours. One whose name leads to this machine (DNS rebinding)
/// is told by `Host`. Pure.
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
