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

/// Callbacks of link.add and link.remove. If `add` or `remove` throws base::ConfigError, nothing
/// has changed.
struct LinkHooks {
  /// Adds a link, see with_link().
  /// @param tried  called with its name once it has tried to open, or after two seconds
  std::function<void(const base::ConfigNode& request,
                     std::function<void(const std::string& name)> tried)>
      add;
  /// @param force  also the link of an armed vehicle
  std::function<void(const std::string& name, bool force)> remove;
  /// Called for each call. @param refusal  nullopt: it was done
  std::function<void(const std::string& client, const std::string& method,
                     const nlohmann::json& params, const std::optional<std::string>& refusal)>
      audit;
};

/// Methods link.add and link.remove.
void add_link_methods(base::rpc::Server& server, const LinkHooks& hooks);

}  // namespace cas::casd
