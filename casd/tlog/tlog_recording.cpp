// SPDX-License-Identifier: BSD-3-Clause
#include "casd/tlog/tlog_recording.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <cerrno>
#include <utility>

#include "base/error.hpp"
#include "base/os/log.hpp"

namespace cas::casd {
namespace {

bool is_full(int error) { return error == ENOSPC || error == EDQUOT || error == EFBIG; }

}  // namespace

void TlogRecording::begin(Options options, base::RunTime now) {
  options_ = std::move(options);
  pause_.reset();
  retry_at_.reset();
  room_ = LogRoom(options_.limits);
  bytes_ = 0;
  lost_ = 0;
  if (files_.begin(options_.files, now)) return;
  const int error = errno;
  if (!options_.insist && !is_full(error)) {
    throw base::ConfigError("recording " + options_.files.name + " in " +
                            files_.folder().path().string() + ": " + base::error_text(error));
  }
  pause(base::error_text(error), now);
}

std::size_t TlogRecording::write(std::span<const std::uint8_t> records, base::RunTime now) {
  std::size_t written = 0;
  if (may_write(records.size(), now) && !records.empty()) {
    const std::size_t done = files_.write(records, now);
    const int error = errno;
    written = count_tlog_records(records.first(done));
    bytes_ += done;
    room_.wrote(done);
    records = records.subspan(done);
    if (records.empty()) {
      go_on();
    } else {
      pause(base::error_text(error), now);
    }
  }
  if (!records.empty()) lost_ += count_tlog_records(records);
  return written;
}

std::uint64_t TlogRecording::leave_deleted() {
  const std::filesystem::path deleted = file();
  const std::optional<TlogFiles::Content> content = files_.leave_deleted();
  if (!content) return 0;
  bytes_ -= content->bytes;
  base::log::error(
      fmt::format("recording: {} was deleted while it was written, with {} packets in it",
                  deleted.string(), content->packets));
  return content->packets;
}

/// Whether it is time to try, and the limits let it.
bool TlogRecording::may_write(std::size_t more, base::RunTime now) {
  if (retry_at_ && now < *retry_at_) return false;
  const std::size_t wanted = retry_at_ ? std::max(more, kRoomToGoOn) : more;
  const std::string current = files_.current().filename();
  if (const auto why = room_.lack(files_.folder(), wanted, current, now)) {
    pause(*why, now);
    return false;
  }
  retry_at_.reset();
  return true;
}

void TlogRecording::pause(std::string why, base::RunTime now) {
  retry_at_ = now + kRetryPeriod;
  const bool begins = !pause_;
  if (begins) {
    paused_since_ = now;
    lost_ = 0;
  }
  pause_ = std::move(why);
  if (begins) {
    base::log::error("recording in " + files_.folder().path().string() + " pauses: " + *pause_ +
                     "; it goes on when it can");
  }
}

void TlogRecording::go_on() {
  if (!pause_) return;
  pause_.reset();
  base::log::info(
      fmt::format("recording goes on in {}; {} packets are not in it", file().string(), lost_));
}

}  // namespace cas::casd
