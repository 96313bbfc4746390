// SPDX-License-Identifier: BSD-3-Clause
#include "casd/autopilot_log/dataflash_pull.hpp"

#include <utility>

#include "mavlink_gen/runtime/codec.hpp"

namespace cas::casd {

void DataflashPull::take(const mav::PacketView& packet) {
  if (const auto block = mav::decode<RemoteLogDataBlock>(packet)) take(*block);
}

void DataflashPull::take(const RemoteLogDataBlock& block) {
  if (stream_.begins(block.seqno) && !begin_file("bin")) return;
  DataflashStream::Part part;
  if (stream_.take(block.seqno, block.data, part, now_) == DataflashStream::Verdict::kStale) {
    // The vehicle sends a log whose beginning casd does not have.
    if (now_ < next_ask_) return;
    restart(now_);
    return order_start();
  }
  hear();
  say(block.seqno, RemoteLogBlockStatus::kAck);
  write({std::move(part.bytes), part.at});
}

void DataflashPull::ask() {
  DataflashStream::Part part;
  for (const std::uint32_t number : stream_.tick(part, now_)) {
    say(number, RemoteLogBlockStatus::kNack);
  }
  write({std::move(part.bytes), part.at});
  if (now_ < next_ask_ || (stream_.began() && !is_silent())) return;
  stream_.expect_another();
  order_start();
}

/// While a log runs, ArduPilot ignores an order to start another one: it is stopped first.
void DataflashPull::order_start() {
  if (!std::exchange(ordered_, true)) say(RemoteLogBlockStatus::kStop, RemoteLogBlockStatus::kAck);
  say(RemoteLogBlockStatus::kStart, RemoteLogBlockStatus::kAck);
  ask_later(retry_, kSilence);
}

void DataflashPull::ask_to_end() {
  if (ordered_) say(RemoteLogBlockStatus::kStop, RemoteLogBlockStatus::kAck);
}

void DataflashPull::forget() {
  stream_.reset();
  ordered_ = false;
}

void DataflashPull::say(std::uint32_t number, std::uint8_t status) {
  RemoteLogBlockStatus message;
  message.seqno = number;
  message.status = status;
  hooks_.send(message);
}

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
