// SPDX-License-Identifier: BSD-3-Clause
#include "casd/tlog/tlog_files.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <string>
#include <system_error>

namespace cas::casd {
namespace {

bool write_all(int fd, std::span<const std::uint8_t> bytes) {
  while (!bytes.empty()) {
    const ssize_t gone = ::write(fd, bytes.data(), bytes.size());
    if (gone < 0 && errno == EINTR) continue;
    if (gone <= 0) return false;
    bytes = bytes.subspan(static_cast<std::size_t>(gone));
  }
  return true;
}

std::filesystem::path numbered(const std::filesystem::path& first, int number) {
  std::filesystem::path name = first;
  return name.replace_filename(first.stem().string() + "." + std::to_string(number) +
                               first.extension().string());
}

constexpr std::size_t kChunkBytes = 64 * 1024;

}  // namespace

bool TlogFiles::open(const std::filesystem::path& first, const TlogRotation& rotation,
                     base::RunTime now) {
  close();
  first_ = first;
  rotation_ = rotation;
  number_ = 0;
  written_.clear();
  return make(first, true, now);
}

bool TlogFiles::write(std::span<const std::uint8_t> records, base::RunTime now) {
  while (!records.empty()) {
    const bool full = size_ > 0 && is_full(tlog_record_bytes(records), now);
    if (full && !rotate(now)) return false;
    // As many records as this file still takes, at least one.
    std::size_t fitting = 0;
    while (fitting < records.size()) {
      const std::size_t next = tlog_record_bytes(records.subspan(fitting));
      if (fitting > 0 && (next == 0 || is_full(fitting + next, now))) break;
      if (next == 0) fitting = records.size();  // no packet: not ours to judge
      fitting += next;
    }
    if (!write_all(fd_, records.first(fitting))) return false;
    size_ += fitting;
    records = records.subspan(fitting);
  }
  return true;
}

void TlogFiles::close() {
  if (fd_ >= 0) ::close(fd_);
  fd_ = -1;
}

bool TlogFiles::make(const std::filesystem::path& file, bool anew, base::RunTime now) {
  const int how = O_WRONLY | O_CREAT | O_CLOEXEC | (anew ? O_TRUNC : O_EXCL);
  const int fd = ::open(file.c_str(), how, 0644);
  if (fd < 0) return false;
  close();
  fd_ = fd;
  size_ = 0;
  opened_ = now;
  written_.push_back(file);
  return true;
}

bool TlogFiles::rotate(base::RunTime now) {
  do {
    if (make(numbered(first_, ++number_), false, now)) break;
    if (errno != EEXIST) return false;
  } while (true);
  while (rotation_.keep > 0 && written_.size() > static_cast<std::size_t>(rotation_.keep)) {
    std::error_code ignored;
    std::filesystem::remove(written_.front(), ignored);
    written_.pop_front();
  }
  return true;
}

bool TlogFiles::is_full(std::size_t next_bytes, base::RunTime now) const {
  if (rotation_.max_bytes > 0 && size_ + next_bytes > rotation_.max_bytes) return true;
  return size_ > 0 && rotation_.max_age > base::Duration{} && now - opened_ >= rotation_.max_age;
}

std::filesystem::path free_tlog_name(const std::filesystem::path& wish) {
  std::filesystem::path name = wish;
  std::error_code ignored;
  for (int number = 1; std::filesystem::exists(name, ignored); ++number) {
    name = numbered(wish, number);
  }
  return name;
}

bool TlogReader::open(const std::filesystem::path& file) {
  buffer_.clear();
  at_ = 0;
  skipped_ = 0;
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error)) return false;  // a FIFO would block the link
  file_ = std::ifstream(file, std::ios::binary);
  return file_.is_open();
}

std::optional<TlogReader::Record> TlogReader::next() {
  for (;; ++at_, ++skipped_) {
    if (buffer_.size() - at_ < kMaxTlogRecordBytes) refill();
    const auto rest = std::span<const std::uint8_t>(buffer_).subspan(at_);
    if (rest.size() <= kTlogStampBytes) return std::nullopt;
    const std::size_t size = tlog_record_bytes(rest);
    if (size == 0 || size > rest.size()) continue;
    at_ += size;
    return Record{tlog_stamp_us(rest), rest.subspan(kTlogStampBytes, size - kTlogStampBytes)};
  }
}

bool TlogReader::refill() {
  buffer_.erase(buffer_.begin(), buffer_.begin() + static_cast<std::ptrdiff_t>(at_));
  at_ = 0;
  const std::size_t kept = buffer_.size();
  buffer_.resize(kept + kChunkBytes);
  file_.read(reinterpret_cast<char*>(buffer_.data() + kept), kChunkBytes);
  buffer_.resize(kept + static_cast<std::size_t>(file_.gcount()));
  return buffer_.size() > kept;
}

}  // namespace cas::casd
