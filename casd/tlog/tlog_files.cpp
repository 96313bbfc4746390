// SPDX-License-Identifier: BSD-3-Clause
#include "casd/tlog/tlog_files.hpp"

#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <string>
#include <utility>
#include <vector>

#include "base/error.hpp"
#include "base/os/disk_error.hpp"
#include "base/os/log.hpp"
#include "casd/tlog/tlog_name.hpp"
#include "mavlink_gen/runtime/public_table.hpp"

namespace cas::casd {
namespace {

/// The length of the first record; of all bytes where they are no record, which is not ours to
/// judge.
std::size_t first_record_bytes(std::span<const std::uint8_t> records) {
  const std::size_t size = mav::services::tlog_record_bytes(records);
  return size == 0 || size > records.size() ? records.size() : size;
}

/// How many of the first `bytes` are whole records.
std::size_t whole_records(std::span<const std::uint8_t> records, std::size_t bytes) {
  std::size_t whole = 0;
  while (whole < bytes) {
    const std::size_t next = whole + first_record_bytes(records.subspan(whole));
    if (next > bytes) break;
    whole = next;
  }
  return whole;
}

/// The file may go on where it is once there is room.
bool lacks_room(int error) { return error == ENOSPC || error == EDQUOT; }

constexpr std::size_t kChunkBytes = 64 * 1024;
constexpr int kMostFiles = 100'000;  // names that are tried

}  // namespace

std::size_t count_tlog_records(std::span<const std::uint8_t> records) {
  std::size_t count = 0;
  for (; !records.empty(); ++count) records = records.subspan(first_record_bytes(records));
  return count;
}

bool TlogFiles::begin(Options options, base::RunTime now) {
  close();
  options_ = std::move(options);
  folder_ = LogFolder(options_.folder);
  number_ = 0;
  made_.clear();
  is_deleted_ = false;
  if (options_.overwrite) folder_.remove(tlog_file_name(options_.name, 0));
  return make_next(now);
}

std::size_t TlogFiles::write(std::span<const std::uint8_t> records, base::RunTime now) {
  std::size_t done = 0;
  while (done < records.size()) {
    const auto rest = records.subspan(done);
    const bool full = size_ > 0 && is_full(first_record_bytes(rest), now);
    if ((!fd_ || full) && !make_next(now)) return done;
    // As many records as this file still takes, at least one.
    std::size_t fitting = first_record_bytes(rest);
    while (fitting < rest.size()) {
      const std::size_t next = fitting + first_record_bytes(rest.subspan(fitting));
      if (is_full(next, now)) break;
      fitting = next;
    }
    const std::size_t whole = append(rest.first(fitting));
    const int error = errno;
    size_ += whole;
    packets_ += count_tlog_records(rest.first(whole));
    done += whole;
    if (whole == fitting) continue;
    const bool has_some = size_ > 0;
    if (!fd_ || !lacks_room(error)) give_up_file();
    errno = error;
    if (error != EFBIG || !has_some) return done;  // else the next file takes more
  }
  return done;
}

/// @return how many bytes of whole records are in the file now; fewer than all with errno set
std::size_t TlogFiles::append(std::span<const std::uint8_t> records) {
  const std::size_t gone = write_some(fd_.get(), records);
  if (gone == records.size()) return gone;
  const int error = errno;
  const std::size_t whole = whole_records(records, gone);
  const bool torn = whole < gone && ::ftruncate(fd_.get(), static_cast<off_t>(size_ + whole)) != 0;
  if (torn) fd_.reset();  // readers skip the torn record; nothing follows it
  errno = error;
  return whole;
}

void TlogFiles::close() {
  const int error = base::close_written(fd_);
  if (error == 0) return;
  base::log::error("recording: " + current().string() +
                   " may lack packets: closing it failed: " + base::error_text(error));
}

std::optional<TlogFiles::Content> TlogFiles::leave_deleted() {
  if (!is_deleted(fd_)) return std::nullopt;
  fd_.reset();
  is_deleted_ = true;
  return Content{std::exchange(packets_, 0), std::exchange(size_, 0)};
}

/// Another file follows this one, which goes where nothing is in it.
void TlogFiles::give_up_file() {
  close();
  if (size_ > 0) return;
  folder_.remove(made_.back());
  made_.pop_back();
  --number_;
}

std::filesystem::path TlogFiles::current() const {
  return made_.empty() ? std::filesystem::path() : folder_.path() / made_.back();
}

bool TlogFiles::make_next(base::RunTime now) {
  base::Descriptor next;
  for (;; ++number_) {
    next = folder_.make(tlog_file_name(options_.name, number_));
    if (next) break;
    if (errno != EEXIST || number_ >= kMostFiles) return false;
  }
  close();
  fd_ = std::move(next);
  size_ = 0;
  packets_ = 0;
  opened_ = now;
  if (std::exchange(is_deleted_, false)) made_.pop_back();
  made_.push_back(tlog_file_name(options_.name, number_++));
  const int keep = options_.rotation.keep;
  while (keep > 0 && made_.size() > static_cast<std::size_t>(keep)) {
    folder_.remove(made_.front());
    made_.pop_front();
  }
  folder_.keep_newest(options_.max_files, made_.back());
  return true;
}

bool TlogFiles::is_full(std::size_t next_bytes, base::RunTime now) const {
  const TlogRotation& rotation = options_.rotation;
  if (rotation.max_bytes > 0 && size_ + next_bytes > rotation.max_bytes) return true;
  return size_ > 0 && rotation.max_age > base::Duration{} && now - opened_ >= rotation.max_age;
}

bool TlogReader::open(const std::filesystem::path& file) {
  records_ = mav::services::TlogSplitter(&mav::public_table());
  ended_ = false;
  failed_ = false;
  try {
    file_ = base::open_foreign_file(file, "log");
  } catch (const base::ConfigError&) {
    return false;
  }
  return true;
}

std::optional<TlogReader::Record> TlogReader::next() {
  for (;;) {
    const std::optional<Record> record = next_read();
    if (record || ended_) return record;
    read_more();
  }
}

bool TlogReader::read_more() {
  std::vector<std::uint8_t> chunk(kChunkBytes);
  const std::size_t size = std::fread(chunk.data(), 1, chunk.size(), file_.get());
  ended_ = size == 0;
  failed_ = ended_ && std::ferror(file_.get()) != 0;
  records_.feed(std::span(chunk).first(size));
  return !ended_;
}

}  // namespace cas::casd
