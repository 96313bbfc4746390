// SPDX-License-Identifier: BSD-3-Clause
#include "casd/autopilot_log/dataflash_stream.hpp"

namespace cas::casd {

DataflashStream::Verdict DataflashStream::take(std::uint32_t number, const Block& block, Part& part,
                                               base::RunTime now) {
  if (begins(number)) {
    reset();
    began_ = true;
  }
  if (!began_) return Verdict::kStale;
  if (number < next_ || early_.contains(number)) return Verdict::kTaken;
  if (number - next_ >= kWindow) return Verdict::kStale;
  another_ = false;
  if (number != next_ && early_.empty()) {
    missing_since_ = now;
    ask_at_ = now + kAskAfter;
  }
  early_.emplace(number, block);
  if (number == next_) take_in_order(part, now);
  return Verdict::kTaken;
}

void DataflashStream::take_in_order(Part& part, base::RunTime now) {
  part.at = std::uint64_t{next_} * RemoteLogDataBlock::kBlockBytes;
  for (auto each = early_.begin(); each != early_.end() && each->first == next_; ++next_) {
    part.bytes.insert(part.bytes.end(), each->second.begin(), each->second.end());
    each = early_.erase(each);
  }
  missing_since_ = now;
  ask_at_ = now + kAskAfter;
}

std::vector<std::uint32_t> DataflashStream::tick(Part& part, base::RunTime now) {
  constexpr std::size_t kMostAtOnce = 32;
  std::vector<std::uint32_t> wanted;
  if (early_.empty()) return wanted;
  if (now - missing_since_ >= kGiveUpAfter) {
    next_ = early_.begin()->first;
    take_in_order(part, now);
    return wanted;
  }
  if (now < ask_at_) return wanted;
  ask_at_ = now + kAskPeriod;
  const std::uint32_t newest = early_.rbegin()->first;
  for (std::uint32_t number = next_; number < newest && wanted.size() < kMostAtOnce; ++number) {
    if (!early_.contains(number)) wanted.push_back(number);
  }
  return wanted;
}

}  // namespace cas::casd
