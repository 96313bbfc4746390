// SPDX-License-Identifier: BSD-3-Clause
#include "mavlink_gen/runtime/signing.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "mavlink/common/all.hpp"
#include "mavlink_gen/runtime/packet_parser.hpp"

namespace {

using namespace cas::mav;
namespace common = mavlink::common;
using Verdict = SignatureVerdict;
using SmallSigning = Signing<Sha256, 2>;

constexpr SigningTime kNow = 1'000'000'000;  // about 2 h 47 min into 2015
constexpr SigningTime kMinute = 60 * kSigningUnitsPerSecond;
constexpr Source kVehicle{1, 1};
constexpr std::uint8_t kLink = 7;

using Bytes = std::vector<std::uint8_t>;

Bytes signed_packet(auto& signing, Source source = kVehicle, std::uint8_t link = kLink,
                    std::uint32_t value = 1) {
  PacketBuffer out;
  out.size =
      signing.encode(common::Attitude{.time_boot_ms = value, .yaw = 1}, source, 0, link, out.bytes);
  return {out.view().begin(), out.view().end()};
}

SmallSigning at(SigningTime time, const char* pass_phrase = "ours") {
  return SmallSigning(signing_key(pass_phrase), time);
}

TEST(Signing, SignedPacketsAreFramedLikeOthersAndVerify) {
  auto sender = at(kNow);
  auto receiver = at(kNow);
  const auto bytes = signed_packet(sender);
  PacketParser parser(common::table());
  int packets = 0;
  parser.feed(bytes, [&](const PacketView& packet) {
    ++packets;
    EXPECT_TRUE(packet.is_signed());
    EXPECT_EQ(packet.signature()[0], kLink);
    EXPECT_EQ(receiver.verify(packet), Verdict::kAccepted);
    EXPECT_EQ(decode<common::Attitude>(packet)->time_boot_ms, 1U);
  });
  EXPECT_EQ(packets, 1);
}

TEST(Signing, SignatureIsTheStartOfTheHashOfKeyAndPacket) {
  auto sender = at(kNow);
  const auto bytes = signed_packet(sender);
  const auto key = signing_key("ours");
  const std::span covered(bytes.data(), bytes.size() - 6);
  const auto digest = Sha256().update(key).update(covered).finish();
  EXPECT_TRUE(std::equal(digest.begin(), digest.begin() + 6, bytes.end() - 6));
  const SigningTime expected = kNow + 1;
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_EQ(bytes[bytes.size() - 12 + i], static_cast<std::uint8_t>(expected >> (8 * i)));
  }
}

TEST(Signing, ReplayIsRefusedOnEveryLink) {
  auto sender = at(kNow);
  auto receiver = at(kNow);
  const auto first = signed_packet(sender);
  const auto second = signed_packet(sender);
  EXPECT_EQ(receiver.verify(view_packet(first)), Verdict::kAccepted);
  EXPECT_EQ(receiver.verify(view_packet(first)), Verdict::kReplayed);
  EXPECT_EQ(receiver.verify(view_packet(second)), Verdict::kAccepted);
  EXPECT_EQ(receiver.verify(view_packet(first)), Verdict::kReplayed);
}

TEST(Signing, ChangedLinkIdBreaksTheSignature) {
  auto sender = at(kNow);
  auto receiver = at(kNow);
  auto bytes = signed_packet(sender);
  bytes[bytes.size() - 13] = kLink + 1;
  EXPECT_EQ(receiver.verify(view_packet(bytes)), Verdict::kBadSignature);
}

TEST(Signing, AnyChangedBitBreaksTheSignature) {
  auto sender = at(kNow);
  const auto bytes = signed_packet(sender);
  for (std::size_t i = 3; i < bytes.size(); ++i) {
    auto changed = bytes;
    changed[i] ^= 0x10;
    auto receiver = at(kNow);
    EXPECT_EQ(receiver.verify(view_packet(changed)), Verdict::kBadSignature) << "byte " << i;
  }
}

TEST(Signing, ForgedFirstPacketLocksNobodyOut) {
  auto attacker = at(kMaxSigningTime - 10, "theirs");
  auto sender = at(kNow);
  auto receiver = at(kNow);
  EXPECT_EQ(receiver.verify(view_packet(signed_packet(attacker))), Verdict::kBadSignature);
  EXPECT_EQ(receiver.stream_count(), 0U);
  EXPECT_EQ(receiver.time(), kNow);
  EXPECT_EQ(receiver.verify(view_packet(signed_packet(sender))), Verdict::kAccepted);
}

TEST(Signing, NewStreamMayLagAMinuteAndNoMore) {
  auto receiver = at(kNow);
  auto old_sender = at(kNow - kMinute - 2);
  EXPECT_EQ(receiver.verify(view_packet(signed_packet(old_sender))), Verdict::kTooOld);
  auto late_sender = at(kNow - kMinute - 1);
  EXPECT_EQ(receiver.verify(view_packet(signed_packet(late_sender))), Verdict::kAccepted);
}

TEST(Signing, KnownStreamMayLagAsLongAsItGrows) {
  auto receiver = at(kNow);
  auto sender = at(kNow);
  EXPECT_EQ(receiver.verify(view_packet(signed_packet(sender))), Verdict::kAccepted);
  receiver.advance(kNow + 100 * kMinute);
  EXPECT_EQ(receiver.verify(view_packet(signed_packet(sender))), Verdict::kAccepted);
}

TEST(Signing, AcceptedPacketMovesOurTimeForwardOnly) {
  auto receiver = at(kNow);
  auto ahead = at(kNow + kMinute);
  EXPECT_EQ(receiver.verify(view_packet(signed_packet(ahead))), Verdict::kAccepted);
  EXPECT_EQ(receiver.time(), kNow + kMinute + 1);
  receiver.advance(kNow);
  EXPECT_EQ(receiver.time(), kNow + kMinute + 1);
}

constexpr auto kNoException = [](const PacketView&) { return false; };
constexpr SigningTime kDay = 24 * 60 * kMinute;

TEST(Signing, APacketFromTheFutureIsRefusedAndMovesNothing) {
  auto receiver = at(kNow);
  auto wrong_clock = at(kNow + 3650 * kDay);
  const auto packet = signed_packet(wrong_clock);
  EXPECT_EQ(receiver.verify(view_packet(packet), kNoException, kDay), Verdict::kTooNew);
  EXPECT_EQ(receiver.time(), kNow);
  EXPECT_EQ(receiver.stream_count(), 0U);
  auto corrected = at(kNow);
  EXPECT_EQ(receiver.verify(view_packet(signed_packet(corrected)), kNoException, kDay),
            Verdict::kAccepted)
      << "the same stream, once its clock is right";
}

TEST(Signing, AKnownStreamThatJumpsIntoTheFutureIsRefusedToo) {
  auto receiver = at(kNow);
  auto sender = at(kNow);
  EXPECT_EQ(receiver.verify(view_packet(signed_packet(sender)), kNoException, kDay),
            Verdict::kAccepted);
  auto jumped = at(kNow + 3650 * kDay);
  EXPECT_EQ(receiver.verify(view_packet(signed_packet(jumped)), kNoException, kDay),
            Verdict::kTooNew);
  EXPECT_EQ(receiver.verify(view_packet(signed_packet(sender)), kNoException, kDay),
            Verdict::kAccepted);
}

TEST(Signing, TheBoundIsAgainstTheClockThatNoPacketMoves) {
  auto receiver = at(kNow);
  auto ahead = at(kNow + kDay - 1);
  EXPECT_EQ(receiver.verify(view_packet(signed_packet(ahead)), kNoException, kDay),
            Verdict::kAccepted);
  EXPECT_EQ(receiver.time(), kNow + kDay);
  EXPECT_EQ(receiver.verify(view_packet(signed_packet(ahead)), kNoException, kDay),
            Verdict::kTooNew)
      << "one packet a day further than the other would lead anywhere";
  receiver.advance(kNow + kMinute);
  EXPECT_EQ(receiver.verify(view_packet(signed_packet(ahead)), kNoException, kDay),
            Verdict::kAccepted);
}

TEST(Signing, FullTableRefusesNewStreamsAndKeepsTheOld) {
  auto sender = at(kNow);
  auto receiver = at(kNow);
  EXPECT_EQ(receiver.verify(view_packet(signed_packet(sender, {1, 1}))), Verdict::kAccepted);
  EXPECT_EQ(receiver.verify(view_packet(signed_packet(sender, {1, 2}))), Verdict::kAccepted);
  EXPECT_EQ(receiver.verify(view_packet(signed_packet(sender, {1, 3}))), Verdict::kTableFull);
  EXPECT_EQ(receiver.verify(view_packet(signed_packet(sender, {1, 1}))), Verdict::kAccepted);
  EXPECT_EQ(receiver.stream_count(), 2U);
}

TEST(Signing, UnsignedPacketsPassByPermissionOnly) {
  auto receiver = at(kNow);
  PacketBuffer unsigned_v2, v1;
  unsigned_v2.size = encode(common::Heartbeat{}, kVehicle, 0, unsigned_v2.bytes);
  v1.size = encode_v1(common::Attitude{}, kVehicle, 0, v1.bytes);
  const auto allow_heartbeat = [](const PacketView& packet) { return packet.message_id == 0; };
  EXPECT_EQ(receiver.verify(view_packet(unsigned_v2.view())), Verdict::kUnsigned);
  EXPECT_EQ(receiver.verify(view_packet(v1.view())), Verdict::kUnsigned);
  const auto allowed = receiver.verify(view_packet(unsigned_v2.view()), allow_heartbeat);
  EXPECT_EQ(allowed, Verdict::kUnsignedAllowed);
  EXPECT_TRUE(accepted(allowed));
  EXPECT_FALSE(accepted(receiver.verify(view_packet(v1.view()), allow_heartbeat)));
}

TEST(Signing, TimestampsGrowEvenWhenTheClockStandsOrGoesBack) {
  auto sender = at(kNow);
  auto receiver = at(kNow);
  for (int i = 0; i < 100; ++i) {
    sender.advance(kNow - static_cast<SigningTime>(i));
    ASSERT_EQ(receiver.verify(view_packet(signed_packet(sender))), Verdict::kAccepted);
  }
}

TEST(Signing, IdleSenderFollowsTheClock) {
  auto sender = at(kNow);
  auto receiver = at(kNow + 10 * kMinute);
  sender.advance(kNow + 10 * kMinute);
  EXPECT_EQ(receiver.verify(view_packet(signed_packet(sender))), Verdict::kAccepted);
}

TEST(Signing, StoredBoundIsNeverReachedBeforeItIsReplaced) {
  struct Store {
    std::vector<SigningTime> bounds;
  } kept;
  const SigningStore store{[](void* context, SigningTime bound) {
                             static_cast<Store*>(context)->bounds.push_back(bound);
                           },
                           &kept};
  SmallSigning sender(signing_key("ours"), kNow, store);
  SigningTime last = 0;
  for (SigningTime t = 0; t < 5 * kMinute; t += kMinute / 7) {
    sender.advance(kNow + t);
    signed_packet(sender);
    last = sender.time();
    ASSERT_FALSE(kept.bounds.empty());
    ASSERT_LT(last, kept.bounds.back());
  }
  EXPECT_GE(kept.bounds.size(), 4U);
  EXPECT_LE(kept.bounds.size(), 8U);
  SmallSigning restarted(signing_key("ours"), kept.bounds.back(), store);
  signed_packet(restarted);
  EXPECT_GT(restarted.time(), last);
}

TEST(Signing, ForwardedPacketCanBeSignedAndStripped) {
  auto router = at(kNow);
  auto receiver = at(kNow);
  PacketBuffer plain, with, without;
  plain.size = encode(common::Attitude{.time_boot_ms = 9}, kVehicle, 3, plain.bytes);
  with.size = router.sign(view_packet(plain.view()), common::Attitude::kCrcExtra, 0, with.bytes);
  EXPECT_EQ(receiver.verify(view_packet(with.view())), Verdict::kAccepted);
  without.size =
      strip_signature(view_packet(with.view()), common::Attitude::kCrcExtra, without.bytes);
  EXPECT_EQ(Bytes(without.view().begin(), without.view().end()),
            Bytes(plain.view().begin(), plain.view().end()));
}

TEST(Signing, TimeCountsTensOfMicrosecondsFrom2015) {
  EXPECT_EQ(signing_time(1'420'070'400'000'000), 0U);
  EXPECT_EQ(signing_time(1'420'070'401'000'000), kSigningUnitsPerSecond);
  EXPECT_EQ(signing_time(0), 0U);
}

}  // namespace
