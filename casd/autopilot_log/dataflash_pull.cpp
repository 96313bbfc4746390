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

}  // namespace cas::casd
