// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>

#include "casd/words/link_words.hpp"

namespace cas::casctl {

/// A counter of a link as casd.status tells it, of one by cause the sum; nullopt: casd does not
/// tell it.
std::optional<std::uint64_t> counter_of(const nlohmann::json& link,
                                        const casd::CounterWords& words);

}  // namespace cas::casctl
