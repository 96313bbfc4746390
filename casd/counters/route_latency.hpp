// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "base/measure/histogram.hpp"
#include "casd/packet/link_id.hpp"

namespace cas::casd {

/// Forwarding times of one sending link by the link that a packet came from. Memory is taken with
/// the first packet of a route. Callers lock.
class RouteLatency {
 public:
  struct Figures {
    LinkId from = kNoLink;
    std::uint64_t count = 0;
    base::Duration p50{}, p99{}, max{};
  };

  void add(LinkId from, base::Duration time) {
    if (from >= times_.size()) return;
    auto& route = times_[from];
    if (!route) route = std::make_unique<base::Histogram>();
    route->add(time);
  }

  std::vector<Figures> figures() const {
    std::vector<Figures> all;
    for (std::size_t from = 0; from < times_.size(); ++from) {
      if (const auto& route = times_[from]) {
        all.push_back({.from = static_cast<LinkId>(from),
                       .count = route->count(),
                       .p50 = route->quantile(0.50),
                       .p99 = route->quantile(0.99),
                       .max = route->max()});
      }
    }
    return all;
  }

 private:
  std::array<std::unique_ptr<base::Histogram>, kMaxLinks> times_;
};

}  // namespace cas::casd
