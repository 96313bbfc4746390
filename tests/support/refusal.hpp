// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>

#include "base/error.hpp"

namespace cas::test {

/// The error of this kind that `action` throws; nullopt when it throws none.
template <class Error, class Action>
std::optional<Error> thrown(Action&& action) {
  try {
    action();
  } catch (const Error& error) {
    return error;
  }
  return std::nullopt;
}

/// Its message; empty when it throws none.
template <class Error = base::ConfigError, class Action>
std::string refusal(Action&& action) {
  try {
    action();
  } catch (const Error& error) {
    return error.what();
  }
  return {};
}

}  // namespace cas::test
