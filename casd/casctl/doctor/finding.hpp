// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace cas::casctl {

/// How a thing is that was looked at.
enum class Health { kGood, kWarning, kBad };

/// One thing that was looked at.
struct Finding {
  Health health = Health::kGood;
  std::string what;        ///< a sentence
  std::string remedy;      ///< advice; empty when all is well
  bool unchecked = false;  ///< of a vehicle that casd only routes for
};

using Findings = std::vector<Finding>;

// They append a finding.

inline void good(Findings& all, std::string what) {
  all.push_back({Health::kGood, std::move(what), "", false});
}

inline void warn(Findings& all, std::string what, std::string remedy) {
  all.push_back({Health::kWarning, std::move(what), std::move(remedy), false});
}

inline void bad(Findings& all, std::string what, std::string remedy) {
  all.push_back({Health::kBad, std::move(what), std::move(remedy), false});
}

}  // namespace cas::casctl
