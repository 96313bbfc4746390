// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <utility>

#include "base/error.hpp"

namespace cas::base {

/// A program's command port, control socket, UDP port or pseudo-terminal's link that is taken or
/// cannot be bound; `main` exits with
/// kExitCommandPort. Unlike a wrong configuration, it may be free when the program starts again.
class CAS_BASE_EXPORT CommandPortError final : public ConfigError {
 public:
  using ConfigError::ConfigError;
};

/// Calls `bind`, which binds the program's own port. @return its result
/// @throws CommandPortError with the sentence of a ConfigError
template <class Bind>
decltype(auto) bind_command_port(Bind&& bind) {
  try {
    return std::forward<Bind>(bind)();
  } catch (const ConfigError& error) {
    throw CommandPortError(error.what());
  }
}

}  // namespace cas::base
