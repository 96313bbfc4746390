// SPDX-License-Identifier: BSD-3-Clause
#include "casd/tlog/tlog_writer.hpp"

#include <cerrno>
#include <chrono>
#include <system_error>

#include "base/error.hpp"
#include "base/os/log.hpp"

namespace cas::casd {
namespace {

// Written at the latest after this: a log survives a crash but for the last moments.
constexpr auto kFlushPeriod = std::chrono::milliseconds(200);

}  // namespace

TlogWriter::~TlogWriter() { stop(); }

void TlogWriter::start(const std::filesystem::path& file, const TlogRotation& rotation) {
  stop();
  if (!files_.open(file, rotation, base::steady_now())) {
    throw base::ConfigError("log " + file.string() + ": " + std::generic_category().message(errno));
  }
  const std::scoped_lock lock(mutex_);
  const auto unix_ns = std::chrono::duration_cast<std::chrono::nanoseconds>(
      std::chrono::system_clock::now().time_since_epoch());
  unix_minus_run_ns_ =
      epoch_ ? epoch_->count() : (unix_ns - base::steady_now().time_since_epoch()).count();
  path_ = file;
  stopping_ = false;
  thread_ = std::thread([this] { run(); });
  active_.store(true, std::memory_order_relaxed);
}

void TlogWriter::stop() {
  if (!thread_.joinable()) return;
  {
    const std::scoped_lock lock(mutex_);
    active_.store(false, std::memory_order_relaxed);
    stopping_ = true;
  }
  more_.notify_one();
  thread_.join();
  files_.close();
}

std::filesystem::path TlogWriter::file() const {
  const std::scoped_lock lock(mutex_);
  return path_;
}

void TlogWriter::record(std::span<const std::uint8_t> packet, base::RunTime now) {
  if (!active()) return;
  const std::scoped_lock lock(mutex_);
  if (stopping_) return;
  if (waiting_.size() + packet.size() > kMaxWaitingBytes) {
    left_out_.fetch_add(1, std::memory_order_relaxed);
    return;
  }
  const auto stamp =
      static_cast<std::uint64_t>((now.time_since_epoch().count() + unix_minus_run_ns_) / 1000);
  append_tlog_record(stamp, packet, waiting_);
  recorded_.fetch_add(1, std::memory_order_relaxed);
}

bool TlogWriter::write(std::span<const std::uint8_t> records) {
  const bool written = files_.write(records, base::steady_now());
  const int error = errno;
  {
    const std::scoped_lock lock(mutex_);
    path_ = files_.current();
  }
  errno = error;
  return written;
}

void TlogWriter::run() {
  std::vector<std::uint8_t> taken;
  bool failed = false;
  for (bool last = false; !last;) {
    {
      std::unique_lock lock(mutex_);
      more_.wait_for(lock, kFlushPeriod, [this] { return stopping_; });
      last = stopping_;
      taken.swap(waiting_);
    }
    if (!failed && !write(taken)) {
      failed = true;
      active_.store(false, std::memory_order_relaxed);
      base::log::error("log " + file().string() + ": " + std::generic_category().message(errno));
    }
    taken.clear();
  }
}

}  // namespace cas::casd
