// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "base/error.hpp"

namespace cas::base::rpc {

/// Thrown by Server::listen_tcp() when another program listens at the address; casd adds how a
/// second casd gets a port of its own.
class AddressInUse final : public ConfigError {
 public:
  using ConfigError::ConfigError;
};

}  // namespace cas::base::rpc
