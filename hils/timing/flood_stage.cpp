// SPDX-License-Identifier: BSD-3-Clause
#include "hils/timing/flood_stage.hpp"

namespace cas::hils {

void FloodStage::turn(base::RunTime now) {
  if (done_) return;
  if (now - last_event_ >= kPatience) {
    // Silence: the bytes in flight are lost.
    line_.forget_open();
    on_way_.clear();
    on_way_bytes_ = 0;
    last_event_ = now;
  }
  ended_ = now >= end_;
  while (!ended_ && on_way_bytes_ < kWindowBytes) {
    const std::size_t before = line_.packets.bytes().size();
    if (way_ == Way::kToBoard) line_.packets.pad(kPaddingBytes);
    const std::uint32_t number = line_.ask(kind_, now);
    on_way_.push_back({number, line_.packets.bytes().size() - before});
    on_way_bytes_ += on_way_.back().bytes;
  }
  done_ = ended_ && on_way_.empty();
}

void FloodStage::on_answer(std::uint32_t number, base::RunTime now) {
  if (!line_.answered(number, now)) return;
  last_event_ = now;
  release_up_to(number);
  if (way_ == Way::kToBoard && now < end_) rate_.add(through_, now);
}

void FloodStage::on_read(std::size_t bytes, base::RunTime now) {
  if (way_ != Way::kFromBoard || now >= end_) return;
  through_ += bytes;
  rate_.add(through_, now);
}

/// Packets before this number are through, or lost: a line keeps the order.
void FloodStage::release_up_to(std::uint32_t number) {
  while (!on_way_.empty() && on_way_.front().number <= number) {
    const Sent& sent = on_way_.front();
    on_way_bytes_ -= sent.bytes;
    if (way_ == Way::kToBoard) through_ += sent.bytes;
    on_way_.pop_front();
  }
}

}  // namespace cas::hils
