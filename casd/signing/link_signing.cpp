// SPDX-License-Identifier: BSD-3-Clause
#include "casd/signing/link_signing.hpp"

#include <algorithm>
#include <utility>

#include "casd/signing/signing_writer.hpp"
#include "mavlink/common/all.hpp"

namespace cas::casd {

LinkSigning::LinkSigning(const SigningConfig& config, std::shared_ptr<PacketSigner> signer,
                         std::shared_ptr<LinkCounters> counters)
    : config_(config), signer_(std::move(signer)), counters_(std::move(counters)) {}

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
    verdict = signer_->verify(packet);
  }
  counters_->rx.signatures[static_cast<std::size_t>(verdict)].add();
  if (!mav::accepted(verdict)) return std::nullopt;

  const int crc_extra = fitting_crc_extra(packet);
  if (crc_extra < 0) return std::nullopt;
  const std::size_t size =
      mav::strip_signature(packet, static_cast<std::uint8_t>(crc_extra), stripped_);
  return mav::view_packet(std::span(stripped_).first(size));
}

std::unique_ptr<PacketWriter> LinkSigning::wrap(std::unique_ptr<PacketWriter> writer) const {
  if (!config_.sign) return writer;
  return std::make_unique<SigningWriter>(std::move(writer), signer_, config_.link_id);
}

void SigningKeys::read(const Topology& topology) {
  for (const LinkConfig& link : topology.links) {
    if (!link.signing || signers_.contains(link.signing->key_file)) continue;
    signers_.emplace(link.signing->key_file,
                     std::make_shared<PacketSigner>(link.signing->key_file));
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
