// SPDX-License-Identifier: BSD-3-Clause
#include "casd/tlog/tlog_reader.hpp"

#include <system_error>

#include "casd/tlog/tlog_record.hpp"

namespace cas::casd {
namespace {

constexpr std::size_t kChunkBytes = 64 * 1024;

}  // namespace

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
