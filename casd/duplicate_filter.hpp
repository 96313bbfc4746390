// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <mutex>
#include <span>
#include <vector>

#include "base/clock.hpp"
#include "casd/link_id.hpp"

namespace cas::casd {

/// Finds packets that come a second time over another link of the same group (redundant paths).
/// A packet that comes again over the same link is not a duplicate: its sender repeated it.
/// May be called from several threads.
class DuplicateFilter {
 public:
  /// @param window  how much later the second copy may come
  explicit DuplicateFilter(base::Duration window);

  /// @return true when another link brought these bytes within the window
  bool is_duplicate(LinkId from, std::span<const std::uint8_t> bytes, base::RunTime now);

 private:
  // Direct-mapped: an entry that is overwritten early lets a duplicate through, never drops one
  // that is none (64 bits of hash).
  static constexpr std::size_t kEntries = 8192;
  struct Entry {
    std::uint64_t hash = 0;
    base::RunTime seen;
    LinkId from = kNoLink;
  };

  base::Duration window_;
  std::mutex mutex_;
  std::vector<Entry> entries_;
};

}  // namespace cas::casd
