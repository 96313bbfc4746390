// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gmock/gmock.h>

#include <string>
#include <type_traits>

#include "tests/support/child_process.hpp"

namespace cas::test {

/// Matches a program that ended with this code and whose output has each of these: a text that is
/// a part of it, or a matcher of all of it.
template <class... Says>
auto EndedWith(int code, const Says&... says) {
  [[maybe_unused]] const auto of_output = [](const auto& each) {
    if constexpr (std::is_convertible_v<decltype(each), std::string>) {
      return testing::HasSubstr(std::string(each));
    } else {
      return each;
    }
  };
  return testing::AllOf(testing::Field("code", &Ended::code, code),
                        testing::Field("output", &Ended::output, of_output(says))...);
}

}  // namespace cas::test
