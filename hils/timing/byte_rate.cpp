// SPDX-License-Identifier: BSD-3-Clause
#include "hils/timing/byte_rate.hpp"

#include <algorithm>

namespace cas::hils {

double ByteRate::bytes_s() const {
  constexpr std::size_t kPieces = 5;
  if (marks_.size() <= kPieces) return 0;
  std::vector<double> rates;
  for (std::size_t i = 0; i < kPieces; ++i) {
    const Mark& from = marks_[i * (marks_.size() - 1) / kPieces];
    const Mark& to = marks_[(i + 1) * (marks_.size() - 1) / kPieces];
    const double seconds = base::to_seconds(to.at - from.at);
    if (seconds > 0) rates.push_back(static_cast<double>(to.total - from.total) / seconds);
  }
  if (rates.empty()) return 0;
  std::ranges::nth_element(rates, rates.begin() + static_cast<std::ptrdiff_t>(rates.size() / 2));
  return rates[rates.size() / 2];
}

}  // namespace cas::hils
