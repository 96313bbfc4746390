// SPDX-License-Identifier: BSD-3-Clause
#include "casd/transport/baud_search.hpp"

#include "mavlink_gen/runtime/packet.hpp"

namespace cas::casd {

void BaudSearch::begin(base::RunTime now) {
  found_ = rates_.size() < 2;
  packets_ = 0;
  unreadable_ = 0;
  due_ = now + kListen;
}

bool BaudSearch::heard(std::size_t packets) {
  packets_ += packets;
  found_ = found_ || packets_ >= kEnoughPackets;
  return found_;
}

bool BaudSearch::fits(std::size_t bytes, std::uint64_t packets, base::RunTime now) {
  if (unreadable_ == 0) unreadable_since_ = now;
  unreadable_ = packets > 0 ? 0 : unreadable_ + bytes;
  // The first part of a packet is not readable either.
  return rates_.size() < 2 || unreadable_ < mav::kMaxPacketBytes ||
         now - unreadable_since_ <= kDeaf;
}

bool BaudSearch::advance(base::RunTime now) {
  if (found_ || now < due_) return false;
  at_ = (at_ + 1) % rates_.size();
  packets_ = 0;
  due_ = now + kListen;
  return true;
}

}  // namespace cas::casd
