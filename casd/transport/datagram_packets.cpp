// SPDX-License-Identifier: BSD-3-Clause
#include "casd/transport/datagram_packets.hpp"

#include <algorithm>
#include <utility>

namespace cas::casd {

void DatagramPackets::reset() {
  whole_.reset();
  halves_.clear();
  due_ = base::RunTime::max();
}

DatagramPackets::Half* DatagramPackets::find(const PeerAddress& sender) {
  const auto found = std::ranges::find_if(
      halves_, [&](const std::unique_ptr<Half>& half) { return half->sender == sender; });
  return found == halves_.end() ? nullptr : found->get();
}

DatagramPackets::Half& DatagramPackets::add(const PeerAddress& sender, bool is_peer) {
  const auto is_stranger = [](const std::unique_ptr<Half>& half) { return !half->is_peer; };
  if (!is_peer &&
      std::ranges::count_if(halves_, is_stranger) >= static_cast<std::ptrdiff_t>(kMaxStrangers)) {
    halves_.erase(std::ranges::find_if(halves_, is_stranger));  // the one that came first
  }
  auto half = std::make_unique<Half>();
  half->sender = sender;
  half->parser = whole_;
  whole_.reset();
  return *halves_.emplace_back(std::move(half));
}

void DatagramPackets::forget_old(base::RunTime now) {
  std::erase_if(halves_, [&](const auto& half) { return now - half->last >= kKept; });
  due_ = base::RunTime::max();
  for (const auto& half : halves_) {
    due_ = std::min(due_, half->last + (half->waits ? kPacketPause : kKept));
  }
}

}  // namespace cas::casd
