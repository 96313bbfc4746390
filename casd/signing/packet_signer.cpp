// SPDX-License-Identifier: BSD-3-Clause
#include "casd/signing/packet_signer.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <charconv>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

#include "base/error.hpp"
#include "base/os/log.hpp"
#include "base/os/write_file.hpp"
#include "base/read_file.hpp"
#include "base/rpc/token.hpp"
#include "casd/packet/signing_clock.hpp"
#include "mavlink_gen/runtime/crc.hpp"

namespace cas::casd {
namespace {

/// The same message as MAVLink 2: version 1 has no place for a signature.
std::size_t as_version_2(const mav::PacketView& packet, std::uint8_t crc_extra,
                         std::span<std::uint8_t, mav::kMaxPacketBytes> out) {
  const std::size_t length = packet.payload.size();
  const std::array<std::uint8_t, mav::kHeaderBytesV2> header{
      mav::kStartV2,
      static_cast<std::uint8_t>(length),
      0,
      0,
      packet.sequence,
      packet.source.system,
      packet.source.component,
      static_cast<std::uint8_t>(packet.message_id),
      0,
      0};
  std::copy(header.begin(), header.end(), out.begin());
  std::copy(packet.payload.begin(), packet.payload.end(), out.begin() + header.size());
  return mav::detail::append_checksum(out.data(), header.size() + length, crc_extra);
}

constexpr std::string_view kHexDigits = "0123456789abcdefABCDEF";

bool is_hex_key(std::string_view line) {
  return line.size() == 2 * mav::SigningKey{}.size() &&
         line.find_first_not_of(kHexDigits) == std::string_view::npos;
}

mav::SigningKey from_hex(std::string_view digits) {
  mav::SigningKey key{};
  for (std::size_t i = 0; i < key.size(); ++i) {
    std::from_chars(digits.data() + 2 * i, digits.data() + 2 * i + 2, key[i], 16);
  }
  return key;
}

/// "/etc/cas/radio.key" -> "etc_cas_radio.key.time": keys of one name in two folders stay apart.
std::string flat_name(const std::filesystem::path& file) {
  std::string name = std::filesystem::absolute(file).lexically_normal().string().substr(1);
  std::replace(name.begin(), name.end(), '/', '_');
  return name + ".time";
}

}  // namespace

int fitting_crc_extra(const mav::PacketView& packet) {
  const bool v1 = packet.version == 1;
  const std::size_t size = (v1 ? mav::kHeaderBytesV1 : mav::kHeaderBytesV2) + packet.payload.size();
  const mav::Crc16 body = mav::Crc16().update(packet.bytes.subspan(1, size - 1));
  const auto received =
      static_cast<std::uint16_t>(packet.bytes[size] | packet.bytes[size + 1] << 8U);
  for (int extra = 0; extra < 256; ++extra) {
    mav::Crc16 whole = body;
    if (whole.update(static_cast<std::uint8_t>(extra)).value() == received) return extra;
  }
  return -1;
}

PacketSigner::PacketSigner(const std::filesystem::path& key_file)
    : key_(read_signing_key(key_file)),
      time_file_(key_file),
      signing_(
          key_, std::max(signing_clock(), time_file_.load()),
          {.store = [](void* self,
                       mav::SigningTime bound) { static_cast<PacketSigner*>(self)->store(bound); },
           .context = this}) {
  if (!time_file_.store(time_file_.load())) {
    throw base::ConfigError(time_file_.path().string() +
                            ": cannot be written; the time of signatures must outlive a restart");
  }
}

void PacketSigner::begin() {
  if (std::exchange(begun_, true)) return;
  const base::MutexLock lock(mutex_);
  warn_of_future();
  store(signing_.time() + mav::Signing<>::kMaxLag);
}

/// The effect of a wrong clock lasts, because the stored time never goes back.
void PacketSigner::warn_of_future() const {
  const mav::SigningTime clock = signing_clock();
  if (signing_.time() <= clock + kMaxPlausibleLead) return;
  const double ahead_h = static_cast<double>(signing_.time() - clock) /
                         static_cast<double>(mav::kSigningUnitsPerSecond) / 3600;
  base::log::warn(
      fmt::format("{}: the time of signatures is {:f} h ahead of the clock; senders "
                  "with the right time are refused as too old",
                  time_file_.path().string(), ahead_h));
}

mav::SignatureVerdict PacketSigner::verify(const mav::PacketView& packet,
                                           mav::SigningTime max_ahead) {
  const base::MutexLock lock(mutex_);
  signing_.advance(signing_clock());
  return signing_.verify(
      packet, [](const mav::PacketView&) { return false; }, max_ahead);
}

mav::SigningTime PacketSigner::time() {
  const base::MutexLock lock(mutex_);
  return signing_.time();
}

std::size_t PacketSigner::sign(const mav::PacketView& packet, std::uint8_t link_id,
                               std::span<std::uint8_t, mav::kMaxPacketBytes> out) {
  const int crc_extra = fitting_crc_extra(packet);
  if (crc_extra < 0) return 0;
  const auto extra = static_cast<std::uint8_t>(crc_extra);
  mav::PacketView version_2 = packet;
  std::array<std::uint8_t, mav::kMaxPacketBytes> converted;
  if (packet.version == 1) {
    const std::size_t size = as_version_2(packet, extra, converted);
    version_2 = mav::view_packet(std::span(converted).first(size));
  }
  const base::MutexLock lock(mutex_);
  signing_.advance(signing_clock());
  return signing_.sign(version_2, extra, link_id, out);
}

// Under the lock, about once a minute: a small file in the page cache.
void PacketSigner::store(mav::SigningTime bound) {
  const bool failed = !time_file_.store(bound);
  if (failed && !store_failed_) {
    base::log::error("the time of signatures cannot be kept in " + time_file_.path().string());
  }
  store_failed_ = failed;
}

mav::SigningKey read_signing_key(const std::filesystem::path& file) {
  const std::string line = base::rpc::read_token(file);
  return is_hex_key(line) ? from_hex(line) : mav::signing_key(line);
}

SigningTimeFile::SigningTimeFile(const std::filesystem::path& key_file) {
  const char* state = std::getenv("STATE_DIRECTORY");
  if (state != nullptr && *state != '\0') {
    path_ = std::filesystem::path(state) / flat_name(key_file);
  } else {
    path_ = key_file.string() + ".time";
  }
}

mav::SigningTime SigningTimeFile::load() const {
  std::error_code none;
  if (!std::filesystem::exists(path_, none) && !none) return 0;
  const std::optional<std::string> text = base::read_file(path_);
  if (!text) {
    throw base::ConfigError(path_.string() +
                            ": cannot be read; the time of signatures must outlive a restart");
  }
  std::istringstream in(*text);
  mav::SigningTime bound = 0;
  return in >> bound && bound <= mav::kMaxSigningTime ? bound : 0;
}

bool SigningTimeFile::store(mav::SigningTime bound) const {
  try {
    // The caller holds the lock of the packets, so this must not wait for a disk.
    base::write_file(path_, std::to_string(bound) + "\n", base::Durability::kCache);
  } catch (const base::ConfigError&) {
    return false;
  }
  return true;
}

}  // namespace cas::casd
