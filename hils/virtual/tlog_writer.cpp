// SPDX-License-Identifier: BSD-3-Clause
#include "hils/virtual/tlog_writer.hpp"

#include <array>
#include <cerrno>
#include <cstring>

#include "base/error.hpp"

namespace cas::hils {

TlogWriter::TlogWriter(const std::filesystem::path& file)
    : path_(file), file_(std::fopen(file.c_str(), "wbe")) {
  if (!file_) throw base::ConfigError("cannot write " + file.string() + ": " + strerror(errno));
}

void TlogWriter::write(std::int64_t stamp_us, std::span<const std::uint8_t> packet) {
  std::array<std::uint8_t, 8> stamp;
  for (std::size_t i = 0; i < stamp.size(); ++i) {
    stamp[i] = static_cast<std::uint8_t>(static_cast<std::uint64_t>(stamp_us) >> (56 - 8 * i));
  }
  std::fwrite(stamp.data(), 1, stamp.size(), file_.get());
  std::fwrite(packet.data(), 1, packet.size(), file_.get());
}

void TlogWriter::close() {
  if (!file_) return;
  const bool written = std::fflush(file_.get()) == 0 && std::ferror(file_.get()) == 0;
  file_.reset();
  if (!written) throw base::ConfigError(path_.string() + " was not written to its end");
}

}  // namespace cas::hils
