// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>

#include "base/os/mutex.hpp"
#include "mavlink_gen/runtime/signing.hpp"

namespace cas::casd {

/// Reads a key of MAVLink 2 signing from the first line of a file: 64 hexadecimal digits are the
/// key itself, anything else of 16 characters or more is a pass phrase as in ground stations.
/// @throws base::ConfigError when it cannot be read, is too short, or others than its owner may
/// read or write it
mav::SigningKey read_signing_key(const std::filesystem::path& file);

/// Where the time of signatures outlives a restart: a small text file with the bound that no
/// signature has reached yet.
class SigningTimeFile {
 public:
  /// Beside the key file, or in systemd's $STATE_DIRECTORY where there is one.
  explicit SigningTimeFile(const std::filesystem::path& key_file);

  /// The stored bound; 0 when there is none, or no number in the file.
  /// @throws base::ConfigError when the file is there and cannot be read
  mav::SigningTime load() const;
  /// Replaces the file. @return false when it cannot be written
  bool store(mav::SigningTime bound) const;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

/// One key with its time and its streams, shared by all links with the same key file: a packet that
/// one of them received cannot be replayed over another. Any thread.
class PacketSigner {
 public:
  /// Starts at the wall clock or at the stored time, whichever is ahead.
  /// @throws base::ConfigError for a key file that is missing or that others may read, and for a
  /// time that cannot be stored
  explicit PacketSigner(const std::filesystem::path& key_file);

  /// Whether this is the key that it was made with.
  bool has_key(const mav::SigningKey& key) const { return key == key_; }

  /// Puts the key in force: packets that an earlier program may have accepted or signed are never
  /// accepted again. Before this the stored time is not changed. From one thread.
  void begin();

  /// @param max_ahead  how far ahead of the clock a packet may be: each accepted packet moves the
  /// receiver's time, so that one with a wrong clock would lock out all others
  mav::SignatureVerdict verify(const mav::PacketView& packet,
                               mav::SigningTime max_ahead = mav::kMaxSigningTime);

  /// The time of the newest signature made or accepted, or of the clock.
  mav::SigningTime time();
  const std::filesystem::path& time_file() const { return time_file_.path(); }

  /// Signs a packet, of MAVLink 1 or 2, signed before or not, of a message known or not.
  /// @return bytes written; 0 when its checksum fits no message
  std::size_t sign(const mav::PacketView& packet, std::uint8_t link_id,
                   std::span<std::uint8_t, mav::kMaxPacketBytes> out);

 private:
  void warn_of_future() const CAS_REQUIRES(mutex_);
  void store(mav::SigningTime bound);

  const mav::SigningKey key_;
  SigningTimeFile time_file_;
  bool store_failed_ = false;
  bool begun_ = false;
  base::Mutex mutex_;
  mav::Signing<> signing_ CAS_GUARDED_BY(mutex_);
};

/// CRC_EXTRA of a packet's message, found from its checksum: a router signs and strips packets of
/// messages that it does not know. @return -1 when none fits
int fitting_crc_extra(const mav::PacketView& packet);

}  // namespace cas::casd
