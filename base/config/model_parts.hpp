// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <map>
#include <string>

namespace cas::base {

/// What a vehicle file makes of a part of its model.
enum class PartUse {
  kFixed,    ///< a link, joint or included model that turns, but is no rotor: a mass at rest
  kLeftOut,  ///< a link or included model: neither mass nor shapes count
};

/// By the name of a link, a joint, or an included or nested model.
using ModelParts = std::map<std::string, PartUse, std::less<>>;

}  // namespace cas::base
