// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <span>

#include "casd/counters/link_counters.hpp"
#include "casd/packet/packet_port.hpp"
#include "casd/signing/packet_signer.hpp"
#include "casd/topology/link_config.hpp"

namespace cas::casd {

/// The signatures of one link: verifies and removes incoming ones, and signs outgoing packets.
///
///   peer --signed--> verify --> strip --> router ...        router --> queue --> sign --> peer
class LinkSigning {
 public:
  LinkSigning(const SigningConfig& config, std::shared_ptr<PacketSigner> signer,
              std::shared_ptr<LinkCounters> counters);

  /// Verifies an incoming packet; on the link's thread.
  /// @return the packet without signature, valid until the next call; nullopt when it is refused
  std::optional<mav::PacketView> admit(const mav::PacketView& packet);

  /// Signs packets of `writer` at the last moment: queues reorder packets, and signatures must have
  /// rising times. Without signing it returns `writer`.
  std::unique_ptr<PacketWriter> wrap(std::unique_ptr<PacketWriter> writer) const;

 private:
  mav::SignatureVerdict judge(const mav::PacketView& packet);
  void note_future(const mav::PacketView& packet, mav::SignatureVerdict verdict);

  const SigningConfig config_;
  const mav::SigningTime max_ahead_;
  const std::shared_ptr<PacketSigner> signer_;
  const std::shared_ptr<LinkCounters> counters_;
  std::array<std::uint8_t, mav::kMaxPacketBytes> stripped_{};
};

/// The keys of a topology: links that name the same file share one signer.
class SigningKeys {
 public:
  /// Reads the key files that are not read yet. @throws base::ConfigError also where a file that
  /// was read before holds another key now
  void read(std::span<const LinkConfig> links);
  /// The keys are in force from now on: see PacketSigner::begin().
  void begin();
  /// @return nothing for a link without `signing`
  std::shared_ptr<LinkSigning> for_link(const LinkConfig& config,
                                        std::shared_ptr<LinkCounters> counters) const;

 private:
  std::map<std::filesystem::path, std::shared_ptr<PacketSigner>> signers_;
};

}  // namespace cas::casd
