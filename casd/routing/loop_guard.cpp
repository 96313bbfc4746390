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
    if (came_elsewhere(from, place, mark, Needs::kAny)) {
      own.calm_at = now + kCalm;
      return Verdict::kCopy;
    }
    own.loops = now < own.calm_at;
    return Verdict::kFine;
  }
  // The packet came twice over this link: one turn, unless its sender repeated it.
  const std::uint32_t gap = mark.since(before);
  if (gap > units(kMemory)) return Verdict::kFine;
  if (before.repeats() || !came_elsewhere(from, place, before, Needs::kOnceBefore)) {
    (*own.owned)[place].store(mark.with_note(kEnough).value, std::memory_order_relaxed);
    return Verdict::kFine;
  }
  if (gap > units(kSoon)) return Verdict::kFine;
  const unsigned turns = before.note() + 1;
  if (turns < kEnough) {
    (*own.owned)[place].store(mark.with_note(turns).value, std::memory_order_relaxed);
    return Verdict::kFine;
  }
  own.loops = true;
  own.calm_at = now + kCalm;
  return Verdict::kFound;
}

bool LoopGuard::came_elsewhere(LinkId from, std::size_t place, Mark mark, Needs needs) const {
  const bool once = needs == Needs::kOnceBefore;
  for (std::size_t link = 0; link < links_.size(); ++link) {
    const Table* const table = links_[link].table.load(std::memory_order_acquire);
    if (table == nullptr || link == from) continue;
    const Mark there{(*table)[place].load(std::memory_order_relaxed)};
    if (!there.is_same(mark) || (once && there.repeats())) continue;
    // Equal times count: a forwarder on this machine sends back within a millisecond.
    if (mark.since(there) <= units(kMemory)) return true;
  }
  return false;
}

}  // namespace cas::casd
