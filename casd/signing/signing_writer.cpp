// SPDX-License-Identifier: BSD-3-Clause
#include "casd/signing/signing_writer.hpp"

#include <algorithm>
#include <utility>

namespace cas::casd {

SigningWriter::SigningWriter(std::unique_ptr<PacketWriter> writer,
                             std::shared_ptr<PacketSigner> signer, std::uint8_t link_id)
    : writer_(std::move(writer)), signer_(std::move(signer)), link_id_(link_id) {}

WriteResult SigningWriter::write(std::span<const PacketRef> packets) {
  sign(packets);
  const WriteResult inner = signed_.empty() ? WriteResult{} : writer_->write(signed_);
  WriteResult result{.broken = inner.broken};
  const bool all = inner.packets == signed_.size();
  result.packets = all ? packets.size() : index_[inner.packets];
  const auto end = std::lower_bound(unsignable_.begin(), unsignable_.end(), result.packets);
  result.unsignable = {unsignable_.begin(), end};
  if (inner.part_of_next > 0) {
    const auto rest = signed_[inner.packets].bytes.subspan(inner.part_of_next);
    rest_.assign(rest.begin(), rest.end());
    // One byte stays due, so that the caller comes back with write_rest().
    result.part_of_next = packets[result.packets].bytes.size() - 1;
  }
  return result;
}

std::ptrdiff_t SigningWriter::write_rest(std::span<const std::uint8_t> bytes) {
  const std::ptrdiff_t gone = writer_->write_rest(rest_);
  if (gone < 0) return gone;
  rest_.erase(rest_.begin(), rest_.begin() + gone);
  return rest_.empty() ? static_cast<std::ptrdiff_t>(bytes.size()) : 0;
}

void SigningWriter::sign(std::span<const PacketRef> packets) {
  bytes_.resize(packets.size() * mav::kMaxPacketBytes);
  signed_.clear();
  index_.clear();
  unsignable_.clear();
  for (std::size_t i = 0; i < packets.size(); ++i) {
    const std::span<std::uint8_t, mav::kMaxPacketBytes> out(
        bytes_.data() + i * mav::kMaxPacketBytes, mav::kMaxPacketBytes);
    const std::size_t size = signer_->sign(mav::view_packet(packets[i].bytes), link_id_, out);
    if (size == 0) {  // no message has such a checksum: damaged before it came here
      unsignable_.push_back(i);
      continue;
    }
    signed_.push_back({packets[i].info, out.first(size)});
    index_.push_back(i);
  }
}

}  // namespace cas::casd
