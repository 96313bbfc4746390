// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "base/error.hpp"

namespace cas::base::rpc {

/// Another program listens at the address.
class AddressInUse final : public ConfigError {
 public:
  using ConfigError::ConfigError;
};

}  // namespace cas::base::rpc
