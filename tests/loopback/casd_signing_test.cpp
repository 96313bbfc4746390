// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <chrono>
#include <fstream>

#include "base/error.hpp"
#include "mavlink_gen/runtime/signing.hpp"
#include "tests/loopback/casd_fixture.hpp"
#include "tests/support/refusal.hpp"

namespace cas::test {
namespace {

using mav::SignatureVerdict;

constexpr const char* kPassPhrase = "a pass phrase of the laboratory";

mav::SigningTime clock_time() {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  const auto us = std::chrono::duration_cast<std::chrono::microseconds>(now).count();
  return mav::signing_time(static_cast<std::uint64_t>(us));
}

/// casd with a signed link to the simulator; the controller's line is in the clear.
class CasdSigning : public testing::Test {
 protected:
  CasdSigning() : peer(mav::signing_key(kPassPhrase), clock_time()) { write_key(0600); }

  void write_key(mode_t mode) {
    std::ofstream(key_file()) << kPassPhrase << "\n";
    ::chmod(key_file().c_str(), mode);
  }
  std::filesystem::path key_file() const { return fixture.folder / "radio.key"; }

  /// On a loaded machine nothing is dropped by age.
  static std::string topology(const std::string& more = {}) {
    return R"(schema: 1
links:
  - {name: sim, type: udp, local: "127.0.0.1:0", remote: "$SIM", queue: {hil_max_age_ms: 60000},
     signing: {key_file: "$DIR/radio.key", link_id: 7)" +
           more + R"(}}
  - {name: fcu, type: serial, device: "$FCU", queue: {hil_max_age_ms: 60000}}
)";
  }

  /// A signed HIL_SENSOR of the peer.
  template <class Signer>
  std::vector<std::uint8_t> signed_sensor(Signer& signer, std::uint64_t number) {
    std::array<std::uint8_t, mav::kMaxPacketBytes> out;
    const std::size_t size = signer.encode(hil_sensor(number), {1, 200}, sequence++, 3, out);
    return {out.begin(), out.begin() + static_cast<std::ptrdiff_t>(size)};
  }
  std::uint64_t judged(SignatureVerdict verdict) const {
    return fixture.status("sim").rx.signatures[static_cast<std::size_t>(verdict)];
  }
  /// Sends a packet that shall be refused, and waits for the refusal.
  void expect_refused(const std::vector<std::uint8_t>& packet, SignatureVerdict verdict) {
    const std::uint64_t before = judged(verdict);
    fixture.sim.send(packet);
    EXPECT_TRUE(fixture.collect_until([&] { return judged(verdict) == before + 1; }));
  }
  void expect_passes(std::uint64_t number) {
    fixture.sim.send(signed_sensor(peer, number));
    ASSERT_TRUE(fixture.collect_until([&] {
      const auto seen = numbers(fixture.at_fcu, kHilSensor);
      return !seen.empty() && seen.back() == number;
    }));
  }

  CasdFixture fixture;
  mav::Signing<> peer;
  std::uint8_t sequence = 0;
};

TEST_F(CasdSigning, TakesSignaturesOffAndSignsWhatGoesOut) {
  fixture.start(topology());
  expect_passes(1);
  EXPECT_FALSE(fixture.at_fcu.packets().front().view().is_signed());

  fixture.fcu.write(fixture.from_fcu(hil_controls(1)));
  fixture.fcu.write(fixture.from_fcu(hil_controls(2)));
  ASSERT_TRUE(fixture.collect_until([&] { return fixture.at_sim.count(kHilControls) == 2; }));
  for (const PacketStream::Packet& packet : fixture.at_sim.packets()) {
    EXPECT_EQ(peer.verify(packet.view()), SignatureVerdict::kAccepted);
    EXPECT_EQ(packet.view().signature()[0], 7);
  }
  EXPECT_EQ(numbers(fixture.at_sim, kHilControls), (std::vector<std::uint64_t>{1, 2}));
}

TEST_F(CasdSigning, ReadsAKeyAgainThatWasCorrectedAfterAFailedReload) {
  fixture.start(kHilTopology);
  std::ofstream(key_file()) << "the pass phrase of another laboratory\n";
  const std::string spare =
      "  - {name: spare, type: udp_server, local: \"127.0.0.1:0\", "
      "signing: {key_file: \"$DIR/none.key\", link_id: 8}}\n";
  for (int time = 0; time < 3; ++time) {
    EXPECT_THROW(fixture.links().reload(fixture.parse(topology() + spare)), base::ConfigError);
  }

  write_key(0600);
  fixture.links().reload(fixture.parse(topology()));
  ASSERT_TRUE(wait_until([&] { return fixture.links().settled(); }));
  fixture.sim.set_remote(fixture.port("sim"));
  expect_passes(1);
}

TEST_F(CasdSigning, RefusesWhatIsUnsignedForgedOrChanged) {
  fixture.start(topology());
  const auto plain = fixture.from_sim(hil_sensor(1));
  expect_refused({plain.begin(), plain.end()}, SignatureVerdict::kUnsigned);

  mav::Signing<> stranger(mav::signing_key("another pass phrase"), clock_time());
  expect_refused(signed_sensor(stranger, 2), SignatureVerdict::kBadSignature);

  auto changed = signed_sensor(peer, 3);
  changed.back() ^= 1U;
  expect_refused(changed, SignatureVerdict::kBadSignature);

  expect_passes(4);
  EXPECT_EQ(fixture.at_fcu.packets().size(), 1U);
}

TEST_F(CasdSigning, RefusesReplaysAlsoOverAnotherLinkWithTheKey) {
  fixture.start(topology() +
                "  - {name: spare, type: udp_server, local: \"127.0.0.1:0\", "
                "signing: {key_file: \"$DIR/radio.key\", link_id: 8}}\n");
  const auto once = signed_sensor(peer, 1);
  fixture.sim.send(once);
  ASSERT_TRUE(fixture.collect_until([&] { return fixture.at_fcu.count(kHilSensor) == 1; }));
  expect_refused(once, SignatureVerdict::kReplayed);

  UdpPeer eavesdropper;
  eavesdropper.set_remote(fixture.port("spare"));
  eavesdropper.send(once);
  EXPECT_TRUE(fixture.collect_until([&] {
    const auto index = static_cast<std::size_t>(SignatureVerdict::kReplayed);
    return fixture.status("spare").rx.signatures[index] == 1;
  }));
  EXPECT_EQ(fixture.status("spare").peers, 0U) << "a refused packet made its sender a peer";
  expect_passes(2);
  EXPECT_EQ(fixture.at_fcu.count(kHilSensor), 2U);
}

TEST_F(CasdSigning, RefusesAFirstPacketThatIsOlderThanAMinute) {
  fixture.start(topology());
  mav::Signing<> late(mav::signing_key(kPassPhrase),
                      clock_time() - 90 * mav::kSigningUnitsPerSecond);
  expect_refused(signed_sensor(late, 1), SignatureVerdict::kTooOld);
  mav::Signing<> slow(mav::signing_key(kPassPhrase),
                      clock_time() - 30 * mav::kSigningUnitsPerSecond);
  fixture.sim.send(signed_sensor(slow, 2));
  EXPECT_TRUE(fixture.collect_until([&] { return fixture.at_fcu.count(kHilSensor) == 1; }));
}

TEST_F(CasdSigning, APacketFromTheFutureLocksNobodyOut) {
  fixture.start(topology());
  constexpr mav::SigningTime kTenYears = 3652ULL * 86'400 * mav::kSigningUnitsPerSecond;
  mav::Signing<> wrong(mav::signing_key(kPassPhrase), clock_time() + kTenYears);
  expect_refused(signed_sensor(wrong, 1), SignatureVerdict::kTooNew);
  const auto future = fixture.status("sim").rx.future_signature;
  ASSERT_TRUE(future.has_value());
  EXPECT_EQ(future->source, (mav::Source{1, 200}));
  EXPECT_EQ(future->link_id, 3);
  EXPECT_TRUE(future->refused);

  // The same stream with the right time, another one, and casd's own signatures.
  expect_passes(2);
  fixture.fcu.write(fixture.from_fcu(hil_controls(1)));
  ASSERT_TRUE(fixture.collect_until([&] { return fixture.at_sim.count(kHilControls) == 1; }));
  EXPECT_EQ(peer.verify(fixture.at_sim.packets().back().view()), SignatureVerdict::kAccepted);
  EXPECT_LT(peer.time(), clock_time() + 3600 * mav::kSigningUnitsPerSecond);

  // A restart does not bring it back: the stored time was not moved.
  fixture.start(topology());
  fixture.sim.set_remote(fixture.port("sim"));
  mav::Signing<> later(mav::signing_key(kPassPhrase),
                       clock_time() + 100 * mav::kSigningUnitsPerSecond);
  fixture.sim.send(signed_sensor(later, 3));
  EXPECT_TRUE(fixture.collect_until([&] { return fixture.at_fcu.count(kHilSensor) == 2; }));
}

TEST_F(CasdSigning, TheBoundOfTheFutureIsConfigured) {
  fixture.start(topology(", max_future_s: 600"));
  constexpr mav::SigningTime kHour = 3600 * mav::kSigningUnitsPerSecond;
  mav::Signing<> ahead(mav::signing_key(kPassPhrase), clock_time() + kHour);
  expect_refused(signed_sensor(ahead, 1), SignatureVerdict::kTooNew);
  fixture.start(topology(", max_future_s: 0"));
  fixture.sim.set_remote(fixture.port("sim"));
  mav::Signing<> far(mav::signing_key(kPassPhrase), clock_time() + 100'000 * kHour);
  fixture.sim.send(signed_sensor(far, 2));
  ASSERT_TRUE(fixture.collect_until([&] { return fixture.at_fcu.count(kHilSensor) == 1; }));
  EXPECT_FALSE(fixture.status("sim").rx.future_signature->refused);
  EXPECT_GT(fixture.status("sim").rx.signing_time, clock_time() + 99'000 * kHour);
}

TEST_F(CasdSigning, NeverSignsWithATimeOfBeforeARestart) {
  fixture.start(topology());
  expect_passes(1);
  const auto time_of = [](const PacketStream::Packet& packet) {
    mav::SigningTime time = 0;
    for (std::size_t i = 6; i > 0; --i) time = time << 8U | packet.view().signature()[i];
    return time;
  };
  fixture.fcu.write(fixture.from_fcu(hil_controls(1)));
  ASSERT_TRUE(fixture.collect_until([&] { return fixture.at_sim.count(kHilControls) == 1; }));
  // A machine whose clock was set back since: only the stored time knows.
  const mav::SigningTime ahead = clock_time() + 3600 * mav::kSigningUnitsPerSecond;
  std::ofstream(key_file().string() + ".time") << ahead << "\n";
  fixture.start(topology());
  fixture.fcu.write(fixture.from_fcu(hil_controls(2)));
  ASSERT_TRUE(fixture.collect_until([&] { return fixture.at_sim.count(kHilControls) == 2; }));
  EXPECT_GT(time_of(fixture.at_sim.packets().back()), ahead);
}

TEST_F(CasdSigning, SignsInTheOrderOfWritingOverAFullLine) {
  fixture.start(R"(schema: 1
links:
  - {name: sim, type: udp, local: "127.0.0.1:0", remote: "$SIM"}
  - {name: fcu, type: serial, device: "$FCU", queue: {hil_max_age_ms: 60000},
     signing: {key_file: "$DIR/radio.key"}}
)");
  // The controller does not read: packets wait, commands overtake, writes end in a packet's middle.
  constexpr std::uint64_t kPackets = 600;
  for (std::uint64_t i = 1; i <= kPackets; ++i) {
    fixture.sim.send(fixture.from_sim(hil_sensor(i)));
    if (i % 50 != 0) continue;
    fixture.sim.send(fixture.from_sim(mavlink::common::CommandLong{}));
    ASSERT_TRUE(wait_until([&] { return fixture.status("sim").rx.packets == i + i / 50; }));
  }
  const auto waiting = fixture.status("fcu").tx;
  EXPECT_GT(waiting.queued, 0U);
  EXPECT_GE(waiting.queue_high_water, waiting.queued);
  ASSERT_TRUE(fixture.collect_until([&] { return fixture.at_fcu.count(kHilSensor) == kPackets; }));
  for (const PacketStream::Packet& packet : fixture.at_fcu.packets()) {
    ASSERT_EQ(peer.verify(packet.view()), SignatureVerdict::kAccepted);
  }
  EXPECT_EQ(fixture.at_fcu.garbage(), 0U);
}

TEST_F(CasdSigning, CarriesPrivateMessagesAndMavlink1) {
  fixture.start(topology());
  fixture.fcu.write(fixture.from_fcu(hil_controls(1)));
  // MAVLink 1 has no place for a signature: it goes on as MAVLink 2.
  std::array<std::uint8_t, mav::kMaxPacketBytes> v1;
  const std::size_t size = mav::encode_v1(hil_controls(2), {1, 1}, 9, v1);
  fixture.fcu.write(std::span(v1).first(size));
  ASSERT_TRUE(fixture.collect_until([&] { return fixture.at_sim.count(kHilControls) == 2; }));
  EXPECT_EQ(peer.verify(fixture.at_sim.packets().back().view()), SignatureVerdict::kAccepted);
  EXPECT_EQ(numbers(fixture.at_sim, kHilControls).back(), 2U);
}

TEST_F(CasdSigning, LetsNamedMessagesComeUnsigned) {
  fixture.start(topology(", allow_unsigned: [RADIO_STATUS]"));
  fixture.sim.send(fixture.from_sim(mavlink::common::RadioStatus{}));
  ASSERT_TRUE(fixture.collect_until(
      [&] { return fixture.at_fcu.count(mavlink::common::RadioStatus::kId) == 1; }));
  EXPECT_EQ(judged(SignatureVerdict::kUnsignedAllowed), 1U);
}

TEST_F(CasdSigning, NeverLetsAKeyPass) {
  fixture.start(topology());
  std::array<std::uint8_t, mav::kMaxPacketBytes> out;
  const std::size_t size =
      peer.encode(mavlink::common::SetupSigning{.target_system = 1, .target_component = 1},
                  {1, 200}, 0, 3, out);
  fixture.sim.send(std::span(out).first(size));
  EXPECT_TRUE(fixture.collect_until([&] { return fixture.status("sim").rx.setup_signing == 1; }));
  expect_passes(1);
  EXPECT_EQ(fixture.at_fcu.packets().size(), 1U);
}

TEST_F(CasdSigning, RefusesAKeyFileThatOthersMayRead) {
  write_key(0640);
  const std::string said = refusal([&] { fixture.start(topology()); });
  EXPECT_NE(said.find("0600"), std::string::npos) << said;
}

}  // namespace
}  // namespace cas::test
