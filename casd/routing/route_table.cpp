// SPDX-License-Identifier: BSD-3-Clause
#include "casd/routing/route_table.hpp"

#include <algorithm>

#include "mavlink/common/high_latency2.hpp"
#include "mavlink_gen/services/vehicle_state.hpp"

namespace cas::casd {

static_assert(comes_rarely(mavlink::common::HighLatency2::kId));

base::Duration silence_of(base::Duration usual, bool rarely) {
  return rarely ? std::max<base::Duration>(usual, mav::services::kHighLatencyTimeout) : usual;
}

RouteTable::RouteTable(base::Duration lifetime) : lifetime_(lifetime) {}

bool RouteTable::learn(std::uint8_t link, mav::Source source, base::RunTime now, bool rarely) {
  PerLink& own = links_[link];
  const auto note = [&](Heard& heard) {
    heard.last = now;
    heard.rarely |= rarely;
  };
  if (own.newest < own.heard.size() && own.heard[own.newest].source == source) {
    note(own.heard[own.newest]);
    return true;
  }
  for (std::size_t i = 0; i < own.heard.size(); ++i) {
    if (own.heard[i].source != source) continue;
    own.newest = i;
    note(own.heard[i]);
    return true;
  }
  if (own.heard.size() == kMaxIdsPerLink) return false;
  own.newest = own.heard.size();
  own.heard.push_back({source, now, rarely});
  set(link, source);
  return true;
}

int RouteTable::expire(std::uint8_t link, base::RunTime now) {
  PerLink& own = links_[link];
  const auto silent = [&](const Heard& heard) {
    return now - heard.last > silence_of(lifetime_, heard.rarely);
  };
  if (std::none_of(own.heard.begin(), own.heard.end(), silent)) return 0;
  std::vector<Heard> kept;
  std::vector<mav::Source> gone;
  for (const Heard& heard : own.heard) {
    if (silent(heard)) {
      gone.push_back(heard.source);
    } else {
      kept.push_back(heard);
    }
  }
  own.heard = std::move(kept);
  own.newest = 0;
  for (const mav::Source source : gone) clear(link, source);
  return static_cast<int>(gone.size());
}

void RouteTable::forget(std::uint8_t link) {
  PerLink& own = links_[link];
  const std::vector<Heard> gone = std::move(own.heard);
  own = PerLink{};
  for (const Heard& heard : gone) clear(link, heard.source);
}

RouteTable::Row& RouteTable::row_of(std::uint8_t system) {
  if (Row* row = rows_[system].load(std::memory_order_acquire)) return *row;
  while (growing_.test_and_set(std::memory_order_acquire)) {
  }
  if (!owned_rows_[system]) owned_rows_[system] = std::make_unique<Row>();
  Row* row = owned_rows_[system].get();
  rows_[system].store(row, std::memory_order_release);
  growing_.clear(std::memory_order_release);
  return *row;
}

void RouteTable::set(std::uint8_t link, mav::Source source) {
  Row& row = row_of(source.system);
  row.by_component[source.component].fetch_or(slot_bit(link), std::memory_order_relaxed);
  row.any.fetch_or(slot_bit(link), std::memory_order_relaxed);
}

void RouteTable::clear(std::uint8_t link, mav::Source source) {
  Row& row = row_of(source.system);
  row.by_component[source.component].fetch_and(~slot_bit(link), std::memory_order_relaxed);
  const auto& heard = links_[link].heard;
  const bool others = std::any_of(heard.begin(), heard.end(), [&](const Heard& other) {
    return other.source.system == source.system;
  });
  if (!others) row.any.fetch_and(~slot_bit(link), std::memory_order_relaxed);
}

}  // namespace cas::casd
