// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "casd/packet/packet_writer.hpp"
#include "casd/signing/packet_signer.hpp"

namespace cas::casd {

/// Signs packets and hands them to the writer behind it. A packet that was not taken is signed
/// again at its next turn: its time must not lie behind what was sent meanwhile. One whose checksum
/// fits no message cannot be signed: it is named in the result and not written.
class SigningWriter final : public PacketWriter {
 public:
  SigningWriter(std::unique_ptr<PacketWriter> writer, std::shared_ptr<PacketSigner> signer,
                std::uint8_t link_id);

  WriteResult write(std::span<const PacketRef> packets) override;
  /// The caller's rest has no signature; what is written is the rest of the signed packet.
  std::ptrdiff_t write_rest(std::span<const std::uint8_t> bytes) override;
  int descriptor() const override { return writer_->descriptor(); }
  std::size_t unsent() const override { return writer_->unsent(); }
  std::size_t added_bytes() const override { return mav::kSignatureBytes; }

 private:
  void sign(std::span<const PacketRef> packets);

  const std::unique_ptr<PacketWriter> writer_;
  const std::shared_ptr<PacketSigner> signer_;
  const std::uint8_t link_id_;
  std::vector<std::uint8_t> bytes_;
  std::vector<PacketRef> signed_;
  std::vector<std::size_t> index_;  ///< of each signed packet among those given
  std::vector<std::size_t> unsignable_;
  std::vector<std::uint8_t> rest_;  ///< of a signed packet that was begun
};

}  // namespace cas::casd
