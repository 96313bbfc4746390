// SPDX-License-Identifier: BSD-3-Clause
#include "base/error.hpp"
#include "hils/tune/tune_search.hpp"

namespace cas::hils {

bool has_search() { return false; }

void search(const SearchPlan&, const FlyPoints&) {
  throw base::ConfigError(
      "this build of hils has no library that searches: install libpagmo-dev (scripts/setup does) "
      "and build again; 'hils eval' works without it");
}

}  // namespace cas::hils
