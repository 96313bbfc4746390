// SPDX-License-Identifier: BSD-3-Clause
#include "casd/routing/loop_guard.hpp"

namespace cas::casd {

LoopGuard::Table* LoopGuard::make_table(Link& link) {
  link.owned = std::make_unique<Table>();
  link.table.store(link.owned.get(), std::memory_order_release);
  return link.owned.get();
}

LoopGuard::Verdict LoopGuard::judge(LinkId from, std::size_t place, Mark mark, Mark before,
                                    base::RunTime now) {
  Link& own = links_[from];
  if (own.loops) {
    if (came_elsewhere(from, place, mark, mark.time())) {
      own.calm_at = now + kCalm;
      return Verdict::kCopy;
    }
    own.loops = now < own.calm_at;
    return Verdict::kFine;
  }
  // Again over this link, and not again over the one that brought it.
  if (mark.time() - before.time() > units(kSoon)) return Verdict::kFine;
  if (!came_elsewhere(from, place, mark, before.time() - 1)) return Verdict::kFine;
  if (now - own.evidence_since > kSoon) {
    own.evidence = 0;
    own.evidence_since = now;
  }
  if (++own.evidence < kEnough) return Verdict::kFine;
  own.evidence = 0;
  own.loops = true;
  own.calm_at = now + kCalm;
  return Verdict::kFound;
}

bool LoopGuard::came_elsewhere(LinkId from, std::size_t place, Mark mark,
                               std::uint32_t latest) const {
  for (std::size_t link = 0; link < links_.size(); ++link) {
    const Table* const table = links_[link].table.load(std::memory_order_acquire);
    if (table == nullptr || link == from) continue;
    const Mark there{(*table)[place].value.load(std::memory_order_relaxed)};
    if (there.is_same(mark) && latest - there.time() <= units(kMemory)) return true;
  }
  return false;
}

}  // namespace cas::casd
