// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "mavlink_gen/parser/model.hpp"

namespace cas::mav::gen {

/// Effect of a change between two versions of a dialect on its users.
enum class Impact : std::uint8_t {
  kBreaks,      ///< old and new peers no longer understand each other
  kMeaning,     ///< the bytes are read as before but mean something else
  kSource,      ///< programs that use a name must change
  kCompatible,  ///< neither
};

/// One difference between two versions of a dialect.
struct Change {
  Impact impact{};
  std::string text;
};

/// Every difference that matters on the wire or in programs; the gravest first.
std::vector<Change> compare(const xml::Dialect& before, const xml::Dialect& after);

/// One line a change: `breaks: message X: ...`.
std::string render(const std::vector<Change>& changes);

}  // namespace cas::mav::gen
