// SPDX-License-Identifier: BSD-3-Clause
#include "casd/signing/link_signing.hpp"

#include <algorithm>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "base/error.hpp"
#include "casd/packet/signing_clock.hpp"
#include "mavlink/common/all.hpp"

namespace cas::casd {
namespace {

/// Signs packets and hands them to the next writer. A packet that was not written is signed again
/// at its next turn: its time must not be older than that of packets sent meanwhile. A packet whose
/// checksum fits no message cannot be signed: the result names it, and it is not written.
class SigningWriter final : public PacketWriter {
 public:
  SigningWriter(std::unique_ptr<PacketWriter> writer, std::shared_ptr<PacketSigner> signer,
                std::uint8_t link_id);

  WriteResult write(std::span<const PacketRef> packets) override;
  /// The caller's rest has no signature; this writes the rest of the signed packet.
  WriteResult write_rest(std::span<const std::uint8_t> bytes) override;
  void spoil_rest() override {
    if (!rest_.empty()) rest_.back() ^= 0xFFU;  // of the signature
  }
  int descriptor() const override { return writer_->descriptor(); }
  std::size_t unsent() const override { return writer_->unsent(); }
  bool moved() override { return writer_->moved(); }
  bool counts_moves() const override { return writer_->counts_moves(); }
  void watch(bool on) override { writer_->watch(on); }
  void nudge() override { writer_->nudge(); }
  bool flush() override {
    if (!writer_->flush()) return false;
    rest_.clear();
    return true;
  }
  std::size_t added_bytes() const override { return mav::kSignatureBytes; }

 private:
  void sign(std::span<const PacketRef> packets);

  const std::unique_ptr<PacketWriter> writer_;
  const std::shared_ptr<PacketSigner> signer_;
  const std::uint8_t link_id_;
  std::vector<std::uint8_t> bytes_;
  std::vector<PacketRef> signed_;
  std::vector<std::size_t> index_;  ///< of each signed packet among those given
  std::vector<Unsent> unsent_;
  std::vector<std::uint8_t> rest_;  ///< of a signed packet that was begun
};

SigningWriter::SigningWriter(std::unique_ptr<PacketWriter> writer,
                             std::shared_ptr<PacketSigner> signer, std::uint8_t link_id)
    : writer_(std::move(writer)), signer_(std::move(signer)), link_id_(link_id) {}

WriteResult SigningWriter::write(std::span<const PacketRef> packets) {
  sign(packets);
  const WriteResult inner = signed_.empty() ? WriteResult{} : writer_->write(signed_);
  WriteResult result{.broken = inner.broken, .done = inner.done};
  const bool all = inner.packets == signed_.size();
  result.packets = all ? packets.size() : index_[inner.packets];
  for (const Unsent& unsent : inner.unsent) unsent_.push_back({index_[unsent.index], unsent.cause});
  std::ranges::sort(unsent_, {}, &Unsent::index);
  const auto end = std::ranges::lower_bound(unsent_, result.packets, {}, &Unsent::index);
  result.unsent = {unsent_.begin(), end};
  if (inner.part_of_next > 0) {
    const auto rest = signed_[inner.packets].bytes.subspan(inner.part_of_next);
    rest_.assign(rest.begin(), rest.end());
    // One byte stays due, so that the caller comes back with write_rest().
    result.part_of_next = packets[result.packets].bytes.size() - 1;
  }
  return result;
}

WriteResult SigningWriter::write_rest(std::span<const std::uint8_t> bytes) {
  WriteResult result = writer_->write_rest(rest_);
  rest_.erase(rest_.begin(), rest_.begin() + static_cast<std::ptrdiff_t>(result.part_of_next));
  result.part_of_next = rest_.empty() ? bytes.size() : 0;
  return result;
}

void SigningWriter::sign(std::span<const PacketRef> packets) {
  bytes_.resize(packets.size() * mav::kMaxPacketBytes);
  signed_.clear();
  index_.clear();
  unsent_.clear();
  for (std::size_t i = 0; i < packets.size(); ++i) {
    const std::span<std::uint8_t, mav::kMaxPacketBytes> out(
        bytes_.data() + i * mav::kMaxPacketBytes, mav::kMaxPacketBytes);
    const std::size_t size = signer_->sign(mav::view_packet(packets[i].bytes), link_id_, out);
    if (size == 0) {  // no message has such a checksum: damaged before it came here
      unsent_.push_back({i, DropCause::kUnsignable});
      continue;
    }
    signed_.push_back({packets[i].info, out.first(size)});
    index_.push_back(i);
  }
}

/// The bound of the configuration in the units of signatures; 0 there means none.
mav::SigningTime signing_units(base::Duration bound) {
  if (bound == base::Duration::zero()) return mav::kMaxSigningTime;
  const double units = base::to_seconds(bound) * static_cast<double>(mav::kSigningUnitsPerSecond);
  return static_cast<mav::SigningTime>(units);
}

}  // namespace

LinkSigning::LinkSigning(const SigningConfig& config, std::shared_ptr<PacketSigner> signer,
                         std::shared_ptr<LinkCounters> counters)
    : config_(config),
      max_ahead_(signing_units(config.max_future)),
      signer_(std::move(signer)),
      counters_(std::move(counters)) {
  counters_->set_signing_file(signer_->time_file().string());
  counters_->rx.signing_time.set(signer_->time());
}

std::optional<mav::PacketView> LinkSigning::admit(const mav::PacketView& packet) {
  using enum mav::SignatureVerdict;
  // A key that is set up over this link would end up on another one, in the clear.
  if (packet.message_id == mavlink::common::SetupSigning::kId) {
    counters_->rx.setup_signing.add();
    return std::nullopt;
  }
  if (!config_.verify) return packet;

  auto verdict = kUnsignedAllowed;
  const auto& allowed = config_.allow_unsigned;
  if (packet.is_signed() ||
      std::find(allowed.begin(), allowed.end(), packet.message_id) == allowed.end()) {
    verdict = judge(packet);
  }
  counters_->rx.signatures[static_cast<std::size_t>(verdict)].add();
  if (!mav::accepted(verdict)) return std::nullopt;

  const int crc_extra = fitting_crc_extra(packet);
  if (crc_extra < 0) return std::nullopt;
  const std::size_t size =
      mav::strip_signature(packet, static_cast<std::uint8_t>(crc_extra), stripped_);
  return mav::view_packet(std::span(stripped_).first(size));
}

mav::SignatureVerdict LinkSigning::judge(const mav::PacketView& packet) {
  const mav::SignatureVerdict verdict = signer_->verify(packet, max_ahead_);
  counters_->rx.signing_time.set(signer_->time());
  using enum mav::SignatureVerdict;
  if (verdict == kAccepted || verdict == kTooNew) note_future(packet, verdict);
  return verdict;
}

void LinkSigning::note_future(const mav::PacketView& packet, mav::SignatureVerdict verdict) {
  const mav::SigningTime time = mav::Signing<>::timestamp(packet);
  if (time <= signing_clock() + mav::Signing<>::kMaxLag) return;
  counters_->set_future_signature({.source = packet.source,
                                   .link_id = packet.signature()[0],
                                   .time = time,
                                   .refused = verdict == mav::SignatureVerdict::kTooNew,
                                   .at = base::steady_now()});
}

std::unique_ptr<PacketWriter> LinkSigning::wrap(std::unique_ptr<PacketWriter> writer) const {
  if (!config_.sign) return writer;
  return std::make_unique<SigningWriter>(std::move(writer), signer_, config_.link_id);
}

void SigningKeys::read(std::span<const LinkConfig> links) {
  for (const LinkConfig& link : links) {
    if (!link.signing) continue;
    const std::filesystem::path& file = link.signing->key_file;
    const auto known = signers_.find(file);
    if (known == signers_.end()) {
      signers_.emplace(file, std::make_shared<PacketSigner>(file));
    } else if (!known->second->has_key(read_signing_key(file))) {
      throw base::ConfigError(file.string() +
                              ": another key takes a restart, or a file of another name");
    }
  }
}

void SigningKeys::begin() {
  for (const auto& [file, signer] : signers_) signer->begin();
}

std::shared_ptr<LinkSigning> SigningKeys::for_link(const LinkConfig& config,
                                                   std::shared_ptr<LinkCounters> counters) const {
  if (!config.signing) return nullptr;
  return std::make_shared<LinkSigning>(*config.signing, signers_.at(config.signing->key_file),
                                       std::move(counters));
}

}  // namespace cas::casd
