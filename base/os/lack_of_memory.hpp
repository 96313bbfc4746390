// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <new>
#include <string_view>
#include <utility>

#include "base/export.hpp"

namespace cas::base {

/// Keeps some memory in reserve for the moment in which `new` gets none: the reserve is let go of
/// and the allocation tried again, so that one refusal costs nothing. The reserve is taken anew as
/// soon as there is memory; a refusal without a reserve is a std::bad_alloc. Once a program.
CAS_BASE_EXPORT void keep_memory_reserve();

/// Refusals so far: allocations that found no memory at their first attempt.
CAS_BASE_EXPORT std::uint64_t memory_refusals();

/// Says, at most once a second, that work of this name was lost for lack of memory. Needs no memory
/// itself.
CAS_BASE_EXPORT void note_lack_of_memory(std::string_view who) noexcept;

/// Runs `work`. A std::bad_alloc ends `work` alone: it is logged, and the caller goes on.
/// @param who  whose work is lost, for the log
/// @return false when it was lost
template <class Work>
bool outlive_lack_of_memory(std::string_view who, Work&& work) {
  try {
    std::forward<Work>(work)();
    return true;
  } catch (const std::bad_alloc&) {
    note_lack_of_memory(who);
    return false;
  }
}

}  // namespace cas::base
