// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "base/error.hpp"

namespace cas::test {

/// The message of the ConfigError that `action` throws; empty when it throws none.
template <class Action>
std::string refusal(Action&& action) {
  try {
    action();
  } catch (const base::ConfigError& error) {
    return error.what();
  }
  return {};
}

}  // namespace cas::test
