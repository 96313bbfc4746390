// SPDX-License-Identifier: BSD-3-Clause
#include "hils/timing/byte_rate.hpp"

#include <algorithm>

namespace cas::hils {
namespace {

constexpr std::size_t kPieces = 5;
/// Marks closer than this share of their mean distance belong to one bunch.
constexpr double kBunch = 0.25;

}  // namespace

std::vector<ByteRate::Mark> ByteRate::ends_of_bunches() const {
  const base::Duration whole = marks_.back().at - marks_.front().at;
  const double mean_s = base::to_seconds(whole) / static_cast<double>(marks_.size() - 1);
  std::vector<Mark> ends;
  for (std::size_t i = 0; i < marks_.size(); ++i) {
    const bool last = i + 1 == marks_.size();
    if (last || base::to_seconds(marks_[i + 1].at - marks_[i].at) > kBunch * mean_s) {
      ends.push_back(marks_[i]);
    }
  }
  return ends;
}

double ByteRate::bytes_s() const {
  if (marks_.size() <= kPieces) return 0;
  const std::vector<Mark> marks = ends_of_bunches();
  const std::size_t pieces = std::min(kPieces, marks.size() - 1);
  std::vector<double> rates;
  for (std::size_t i = 0; i < pieces; ++i) {
    const Mark& from = marks[i * (marks.size() - 1) / pieces];
    const Mark& to = marks[(i + 1) * (marks.size() - 1) / pieces];
    const double seconds = base::to_seconds(to.at - from.at);
    if (seconds > 0) rates.push_back(static_cast<double>(to.total - from.total) / seconds);
  }
  if (rates.empty()) return 0;
  const std::size_t middle = (rates.size() - 1) / 2;  // of two the lower one
  std::ranges::nth_element(rates, rates.begin() + static_cast<std::ptrdiff_t>(middle));
  return rates[middle];
}

}  // namespace cas::hils
