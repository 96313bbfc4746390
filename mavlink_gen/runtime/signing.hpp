// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string_view>

#include "mavlink_gen/runtime/codec.hpp"
#include "mavlink_gen/runtime/packet.hpp"
#include "mavlink_gen/runtime/sha256.hpp"

namespace cas::mav {

/// The secret that all nodes of a network share.
using SigningKey = std::array<std::uint8_t, 32>;

/// Time of signatures: units of 10 us since the start of 2015 (UTC), 48 bit on the wire. Source:
/// [MAVLink], Message Signing.
using SigningTime = std::uint64_t;

inline constexpr SigningTime kSigningUnitsPerSecond = 100'000;
inline constexpr SigningTime kMaxSigningTime = (SigningTime{1} << 48U) - 1;

/// The signing time of a wall clock; 0 before 2015.
/// @param unix_us  microseconds since the start of 1970 (UTC)
constexpr SigningTime signing_time(std::uint64_t unix_us) {
  constexpr std::uint64_t kStartOf2015 = 1'420'070'400'000'000;  // us, Unix time
  return unix_us < kStartOf2015 ? 0 : (unix_us - kStartOf2015) / 10;
}

/// The key that ground stations make of a pass phrase: its SHA-256.
inline SigningKey signing_key(std::string_view pass_phrase) {
  const auto* bytes = reinterpret_cast<const std::uint8_t*>(pass_phrase.data());
  return Sha256().update({bytes, pass_phrase.size()}).finish();
}

/// What verify() decides about a packet.
enum class SignatureVerdict : std::uint8_t {
  kAccepted,
  kUnsignedAllowed,  ///< no signature, but the caller lets this packet pass
  kUnsigned,         ///< refused: no signature
  kBadSignature,     ///< refused: not made with our key, or changed on the way
  kReplayed,         ///< refused: not newer than the last packet of its stream
  kTooOld,           ///< refused: first packet of a stream, too far behind our time
  kTableFull,        ///< refused: first packet of a stream, and no room for another stream
  kTooNew,           ///< refused: further ahead of our clock than the caller lets a packet be
};

/// Whether the packet may be used.
constexpr bool accepted(SignatureVerdict verdict) {
  return verdict == SignatureVerdict::kAccepted || verdict == SignatureVerdict::kUnsignedAllowed;
}

/// Where the time is kept over a restart. `store` gets a bound that no timestamp has reached yet;
/// it is called before the bound of the call before is reached, about once a minute. A start with
/// the last stored bound therefore never repeats a timestamp. It must not throw.
struct SigningStore {
  void (*store)(void* context, SigningTime bound){};
  void* context{};
};

/// Signs and verifies the packets of one node with one key, on all its links: a packet that came in
/// on one link cannot be played again on another. Not synchronised: callers on several threads
/// lock.
///
/// The time is moved by advance() and by packets of authenticated peers, never backwards. A time
/// that comes from GPS should not be given to advance(): whoever fakes GPS would lock out all
/// peers. A peer with a wrong clock would do so too: `max_ahead` of verify() bounds how far one
/// packet may be ahead of the clock, which packets do not move.
///
/// @tparam Hash         like Sha256: update(span), finish()
/// @tparam max_streams  senders that are told apart: (system, component, link id)
template <class Hash = Sha256, std::size_t max_streams = 32>
class Signing {
 public:
  /// A new stream may lag this much behind our time: one minute.
  static constexpr SigningTime kMaxLag = 60 * kSigningUnitsPerSecond;

  /// @param start  the larger of the clock and what `store` kept; 0 where there is neither
  Signing(const SigningKey& key, SigningTime start, SigningStore store = {})
      : key_(key), store_(store), clock_(start), time_(start), bound_(start) {}

  /// Sets the time to the clock's where that is ahead.
  void advance(SigningTime clock) {
    if (clock > kMaxSigningTime) return;
    if (clock > clock_) clock_ = clock;
    move_to(clock);
  }

  /// Time of the newest signature made or accepted, or of the clock.
  SigningTime time() const { return time_; }
  /// Senders heard with a right signature so far.
  std::size_t stream_count() const { return size_; }

  /// Packs and signs a message; each packet gets a later timestamp than the one before.
  /// @return bytes written
  template <class Message>
  std::size_t encode(const Message& message, Source source, std::uint8_t sequence,
                     std::uint8_t link_id, std::span<std::uint8_t, kMaxPacketBytes> out) {
    const auto size = detail::encode_v2(message, source, sequence, kIncompatSigned, out.data());
    return append_signature(out, size, link_id);
  }

  /// Signs a packet again that is to be forwarded, or for the first time.
  /// @param crc_extra  of the packet's message: the checksum changes with the flag
  /// @return bytes written, 0 for a MAVLink 1 packet
  std::size_t sign(const PacketView& packet, std::uint8_t crc_extra, std::uint8_t link_id,
                   std::span<std::uint8_t, kMaxPacketBytes> out) {
    if (packet.version != 2) return 0;
    const auto size = kHeaderBytesV2 + packet.payload.size();
    std::memcpy(out.data(), packet.bytes.data(), size);
    out[2] |= kIncompatSigned;
    return append_signature(out, detail::append_checksum(out.data(), size, crc_extra), link_id);
  }

  /// Judges a packet whose checksum is right. Only an accepted packet changes anything.
  SignatureVerdict verify(const PacketView& packet) {
    return verify(packet, [](const PacketView&) { return false; });
  }

  /// Likewise, with exceptions.
  /// @param allow_unsigned  bool(const PacketView&): says which packets pass without a signature,
  ///                        e.g. RADIO_STATUS of a modem
  /// @param max_ahead       how far a packet may be ahead of our clock. MAVLink knows no such bound
  template <class AllowUnsigned>
  SignatureVerdict verify(const PacketView& packet, AllowUnsigned&& allow_unsigned,
                          SigningTime max_ahead = kMaxSigningTime) {
    if (!packet.is_signed()) {
      return allow_unsigned(packet) ? SignatureVerdict::kUnsignedAllowed
                                    : SignatureVerdict::kUnsigned;
    }
    const auto trailer = packet.signature();
    const auto signed_bytes = packet.bytes.first(packet.bytes.size() - kSignatureLength);
    if (!same(signature_of(signed_bytes), trailer.last(kSignatureLength))) {
      return SignatureVerdict::kBadSignature;
    }
    return judge_time({packet.source, trailer[0]}, timestamp(packet), max_ahead);
  }

  /// The time that a signed packet carries.
  static SigningTime timestamp(const PacketView& signed_packet) {
    return load_time(signed_packet.signature().data() + 1);
  }

 private:
  static constexpr std::size_t kSignatureLength = 6;
  static constexpr std::size_t kTimeLength = 6;
  using Signature = std::array<std::uint8_t, kSignatureLength>;

  struct StreamKey {
    Source source;
    std::uint8_t link_id{};
    friend constexpr bool operator==(const StreamKey&, const StreamKey&) = default;
  };

  struct Stream {
    StreamKey key;
    SigningTime last{};
  };

  static SigningTime load_time(const std::uint8_t* p) {
    SigningTime time = 0;
    for (std::size_t i = kTimeLength; i > 0; --i) time = time << 8U | p[i - 1];
    return time;
  }

  /// Compares in a time that does not depend on where the first difference is.
  static bool same(const Signature& a, std::span<const std::uint8_t> b) {
    unsigned difference = 0;
    for (std::size_t i = 0; i < a.size(); ++i) difference |= static_cast<unsigned>(a[i] ^ b[i]);
    return difference == 0;
  }

  Signature signature_of(std::span<const std::uint8_t> bytes) const {
    Hash hash;
    hash.update(key_);
    hash.update(bytes);
    const auto digest = hash.finish();
    Signature signature;
    std::memcpy(signature.data(), digest.data(), signature.size());
    return signature;
  }

  /// Adds link id, timestamp and signature behind the checksum.
  std::size_t append_signature(std::span<std::uint8_t> out, std::size_t size,
                               std::uint8_t link_id) {
    const auto time = next_time();
    out[size++] = link_id;
    for (std::size_t i = 0; i < kTimeLength; ++i) {
      out[size++] = static_cast<std::uint8_t>(time >> (8 * i));
    }
    const auto signature = signature_of(out.first(size));
    std::memcpy(out.data() + size, signature.data(), signature.size());
    return size + signature.size();
  }

  /// Strictly increasing; tells the store before the stored bound is passed.
  SigningTime next_time() {
    if (time_ < kMaxSigningTime) ++time_;
    if (time_ >= bound_) {
      bound_ = time_ + kMaxLag;
      if (store_.store != nullptr) store_.store(store_.context, bound_);
    }
    return time_;
  }

  void move_to(SigningTime time) {
    if (time > time_) time_ = time;
  }

  SignatureVerdict judge_time(const StreamKey& key, SigningTime time, SigningTime max_ahead) {
    auto* stream = find(key);
    if (stream != nullptr && time <= stream->last) return SignatureVerdict::kReplayed;
    if (time > clock_ && time - clock_ > max_ahead) return SignatureVerdict::kTooNew;
    if (stream == nullptr) {
      if (time + kMaxLag < time_) return SignatureVerdict::kTooOld;
      if (size_ == max_streams) return SignatureVerdict::kTableFull;
      stream = &streams_[size_++];
      stream->key = key;
    }
    stream->last = time;
    move_to(time);
    return SignatureVerdict::kAccepted;
  }

  Stream* find(const StreamKey& key) {
    for (std::size_t i = 0; i < size_; ++i) {
      if (streams_[i].key == key) return &streams_[i];
    }
    return nullptr;
  }

  SigningKey key_;
  SigningStore store_;
  SigningTime clock_;  ///< what advance() said, and the start
  SigningTime time_;   ///< the same, moved by accepted packets too
  SigningTime bound_;
  std::array<Stream, max_streams> streams_{};
  std::size_t size_{};
};

/// A copy of a signed packet without flag and signature, e.g. for a log that others may read.
/// @return bytes written; an unsigned packet is copied as it is
inline std::size_t strip_signature(const PacketView& packet, std::uint8_t crc_extra,
                                   std::span<std::uint8_t, kMaxPacketBytes> out) {
  if (!packet.is_signed()) {
    std::memcpy(out.data(), packet.bytes.data(), packet.bytes.size());
    return packet.bytes.size();
  }
  const auto size = kHeaderBytesV2 + packet.payload.size();
  std::memcpy(out.data(), packet.bytes.data(), size);
  out[2] = static_cast<std::uint8_t>(out[2] & ~unsigned{kIncompatSigned});
  return detail::append_checksum(out.data(), size, crc_extra);
}

}  // namespace cas::mav
