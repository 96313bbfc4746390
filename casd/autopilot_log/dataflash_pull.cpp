// SPDX-License-Identifier: BSD-3-Clause
#include "casd/autopilot_log/dataflash_pull.hpp"

#include <algorithm>
#include <utility>

#include "mavlink_gen/runtime/codec.hpp"

namespace cas::casd {

void DataflashPull::on_packet(const mav::PacketView& packet, base::RunTime now) {
  if (!wanted_) return;
  if (const auto block = mav::decode<RemoteLogDataBlock>(packet)) take(*block, now);
}

void DataflashPull::take(const RemoteLogDataBlock& block, base::RunTime now) {
  if (stream_.begins(block.seqno)) {
    if (now < next_file_) return;
    next_file_ = now + kFilePeriod;
    hooks_.end();
    hooks_.begin("bin");
  }
  DataflashStream::Part part;
  if (stream_.take(block.seqno, block.data, part, now) == DataflashStream::Verdict::kStale) {
    // The vehicle sends a log whose beginning casd does not have.
    if (now < next_ask_) return;
    restart(now);
    return ask(now);
  }
  heard_at_ = now;
  retry_ = kFirstRetry;
  say(block.seqno, RemoteLogBlockStatus::kAck);
  write(std::move(part), now);
}

void DataflashPull::write(DataflashStream::Part part, base::RunTime now) {
  if (part.bytes.empty()) return;
  if (hooks_.write({std::move(part.bytes), part.at})) return;
  stop(now);
  next_ask_ = now + kSilence;
}

void DataflashPull::tick(base::RunTime now) {
  wanted_ = true;
  DataflashStream::Part part;
  for (const std::uint32_t number : stream_.tick(part, now)) {
    say(number, RemoteLogBlockStatus::kNack);
  }
  write(std::move(part), now);
  if (now < next_ask_ || (stream_.began() && now - heard_at_ <= kSilence)) return;
  stream_.expect_another();
  ask(now);
}

/// While a log runs, ArduPilot ignores an order to start another one: it is stopped first.
void DataflashPull::ask(base::RunTime now) {
  if (!std::exchange(ordered_, true)) say(RemoteLogBlockStatus::kStop, RemoteLogBlockStatus::kAck);
  say(RemoteLogBlockStatus::kStart, RemoteLogBlockStatus::kAck);
  next_ask_ = now + retry_;
  retry_ = std::min(2 * retry_, base::Duration(kSilence));
}

void DataflashPull::stop(base::RunTime now) {
  if (ordered_) say(RemoteLogBlockStatus::kStop, RemoteLogBlockStatus::kAck);
  restart(now);
  wanted_ = false;
}

void DataflashPull::restart(base::RunTime now) {
  stream_.reset();
  hooks_.end();
  ordered_ = false;
  next_ask_ = now;
}

void DataflashPull::say(std::uint32_t number, std::uint8_t status) {
  RemoteLogBlockStatus message;
  message.seqno = number;
  message.status = status;
  hooks_.send(message);
}

}  // namespace cas::casd
