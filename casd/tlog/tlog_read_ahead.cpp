// SPDX-License-Identifier: BSD-3-Clause
#include "casd/tlog/tlog_read_ahead.hpp"

#include <span>
#include <thread>
#include <utility>

#include "base/os/lack_of_memory.hpp"
#include "base/os/thread.hpp"
#include "casd/tlog/tlog_files.hpp"

namespace cas::casd {

TlogReadAhead::TlogReadAhead(const std::filesystem::path& file)
    : shared_(std::make_shared<Shared>()) {
  std::thread([file, shared = shared_] {
    base::lower_this_thread("casd:read tlog");
    if (!base::outlive_lack_of_memory("played log", [&] { read(file, *shared); })) {
      shared->unreadable = true;
      shared->last = true;
      shared->records.clear();
      hand_over(*shared);
    }
  }).detach();
}

TlogReadAhead::~TlogReadAhead() {
  shared_->abandoned.store(true);
  shared_->full.store(false);
  shared_->full.notify_one();
}

std::optional<TlogReadAhead::Record> TlogReadAhead::next() {
  if (at_ == records_.size() && !take_piece()) return std::nullopt;
  const auto rest = std::span<const std::uint8_t>(records_).subspan(at_);
  const std::size_t size = mav::services::tlog_record_bytes(rest);
  at_ += size;
  return Record{
      mav::services::tlog_stamp_us(rest),
      rest.subspan(mav::services::kTlogStampBytes, size - mav::services::kTlogStampBytes)};
}

/// @return whether there is a record now
bool TlogReadAhead::take_piece() {
  if (last_ || !shared_->full.load()) return false;
  records_.clear();
  records_.swap(shared_->records);
  at_ = 0;
  last_ = shared_->last;
  unreadable_ = shared_->unreadable;
  skipped_bytes_ = shared_->skipped_bytes;
  shared_->full.store(false);
  shared_->full.notify_one();
  return !records_.empty();
}

void TlogReadAhead::read(const std::filesystem::path& file, Shared& shared) {
  TlogReader log;
  shared.unreadable = !log.open(file);
  bool more = !shared.unreadable;
  do {
    more = more && log.read_more();
    while (const auto record = log.next_read()) {
      append_tlog_record(record->unix_us, record->packet, shared.records);
    }
    shared.last = !more;
    shared.unreadable |= log.failed();
    shared.skipped_bytes = log.skipped_bytes();
    if (more && shared.records.empty()) continue;
    if (!hand_over(shared)) return;
  } while (more && !shared.abandoned.load());
}

/// Waits until the player has taken the piece. @return false when the player is gone
bool TlogReadAhead::hand_over(Shared& shared) {
  shared.full.store(true);
  if (!shared.abandoned.load())
    shared.full.wait(true);  // the player may have left before the store
  return !shared.abandoned.load();
}

}  // namespace cas::casd
