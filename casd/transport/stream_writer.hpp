// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <sys/uio.h>

#include "base/os/descriptor.hpp"
#include "casd/packet/packet_port.hpp"

namespace cas::casd {

/// Packets end to end into a byte stream: a serial line or a TCP connection.
class StreamWriter final : public PacketWriter {
 public:
  enum class Kind {
    kSerial,          ///< a line whose driver knows what it has not sent
    kPseudoTerminal,  ///< no line behind it
    kSocket
  };
  StreamWriter(base::Descriptor descriptor, Kind kind)
      : descriptor_(std::move(descriptor)), kind_(kind) {}

  WriteResult write(std::span<const PacketRef> packets) override;
  std::ptrdiff_t write_rest(std::span<const std::uint8_t> bytes) override;
  std::size_t unsent() const override;
  int descriptor() const override { return descriptor_.get(); }

 private:
  std::ptrdiff_t write_vector(iovec* parts, std::size_t count);

  base::Descriptor descriptor_;
  Kind kind_;
};

}  // namespace cas::casd
