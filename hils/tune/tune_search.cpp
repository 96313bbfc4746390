// SPDX-License-Identifier: BSD-3-Clause
#include "hils/tune/tune_search.hpp"

#include <dlfcn.h>

#include <string>

#include "base/error.hpp"

namespace cas::hils {

namespace {

/// The library that searches, opened for the first search.
decltype(&cas_tune_search) open_search() {
  const std::string file = CAS_TUNE_SEARCH_FILE;
  if (file.empty()) {
    throw base::ConfigError(
        "this build of hils has no library that searches: install libpagmo-dev (scripts/setup "
        "does) and build again; 'hils eval' works without it");
  }
  void* const library = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);  // where hils has its own
  void* const entry = library == nullptr ? nullptr : dlsym(library, kTuneSearch);
  if (entry == nullptr) {
    throw base::ConfigError("hils cannot search: " + std::string(dlerror()));
  }
  return reinterpret_cast<decltype(&cas_tune_search)>(entry);
}

}  // namespace

bool has_search() { return !std::string(CAS_TUNE_SEARCH_FILE).empty(); }

void search(const SearchPlan& plan, const FlyPoints& fly) {
  static const auto search_with_library = open_search();
  search_with_library(plan, fly);
}

}  // namespace cas::hils
