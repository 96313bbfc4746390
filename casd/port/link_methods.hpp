// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "base/rpc/server.hpp"

namespace cas::base {
class ConfigNode;
}

namespace cas::casd {

/// What link.add and link.remove act on. The first two throw base::ConfigError, and then nothing
/// has changed.
struct LinkHooks {
  /// Adds a link, see with_link(). @return its name
  std::function<std::string(const base::ConfigNode& request)> add;
  /// @param force  also the link of an armed vehicle
  std::function<void(const std::string& name, bool force)> remove;
  /// Takes each call. @param refusal  nothing: it was done
  std::function<void(const std::string& client, const std::string& method,
                     const nlohmann::json& params, const std::optional<std::string>& refusal)>
      audit;
};

/// Methods link.add and link.remove.
void add_link_methods(base::rpc::Server& server, const LinkHooks& hooks);

}  // namespace cas::casd
