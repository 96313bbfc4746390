// SPDX-License-Identifier: BSD-3-Clause
#include "mavlink_gen/runtime/crc.hpp"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <random>
#include <span>
#include <string_view>
#include <vector>

#include "mavlink_gen/runtime/crc_over_zeros.hpp"

namespace cas::mav::test {
namespace {

using Bytes = std::vector<std::uint8_t>;

constexpr std::uint16_t kValues[] = {0x0000, 0x0001, 0x8000, 0xFFFF, 0x1234, 0xBEEF};

/// Bit by bit, as the definition says.
std::uint16_t by_bits(std::uint16_t crc, std::span<const std::uint8_t> bytes) {
  for (const std::uint8_t byte : bytes) {
    crc = static_cast<std::uint16_t>(crc ^ byte);
    for (int bit = 0; bit < 8; ++bit) {
      crc = static_cast<std::uint16_t>(crc >> 1U ^ ((crc & 1U) != 0 ? 0x8408U : 0U));
    }
  }
  return crc;
}

Bytes any_bytes(std::size_t count) {
  std::mt19937 random(7);  // NOLINT: the same bytes in each run
  Bytes bytes(count);
  for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(random());
  return bytes;
}

// The check value of CRC-16/MCRF4XX (G. Cook, Catalogue of parametrised CRC algorithms).
TEST(Crc16, HasTheCheckValueOfItsAlgorithm) {
  constexpr std::string_view kText = "123456789";
  const Bytes bytes(kText.begin(), kText.end());
  EXPECT_EQ(Crc16().update(bytes).value(), 0x6F91);
  EXPECT_EQ(Crc16().update_by_tables(bytes).value(), 0x6F91);
}

// Lengths around those of words and blocks.
TEST(Crc16, IsThatOfItsDefinitionForAnyLength) {
  constexpr std::size_t kMostBytes = 300;
  const Bytes bytes = any_bytes(kMostBytes + 16);
  for (const std::uint16_t value : kValues) {
    for (std::size_t size = 0; size <= kMostBytes; ++size) {
      const auto begin = bytes.begin() + static_cast<std::ptrdiff_t>(size % 16);
      const Bytes part(begin, begin + static_cast<std::ptrdiff_t>(size));  // nothing behind it
      const std::uint16_t expected = by_bits(value, part);
      ASSERT_EQ(Crc16(value).update(part).value(), expected) << size;
      ASSERT_EQ(Crc16(value).update_by_tables(part).value(), expected) << size;
      Crc16 singly(value);
      for (const std::uint8_t byte : part) singly.update(byte);
      ASSERT_EQ(singly.value(), expected) << size;
    }
  }
}

TEST(Crc16, MovesOverZerosAsIfTheyWereRead) {
  const Bytes zeros(detail::kMaxChecksummedBytes, 0);
  for (const std::uint16_t value : kValues) {
    for (std::size_t n = 0; n <= zeros.size(); ++n) {
      ASSERT_EQ(crc_over_zeros(value, n), Crc16(value).update({zeros.data(), n}).value()) << n;
    }
  }
}

TEST(Crc16, AnExtraFitsExactlyWhenOneOf256Does) {
  constexpr std::uint16_t kPayloadCrc = 0x5AC3;
  std::vector<bool> reached(65536);
  for (unsigned extra = 0; extra < 256; ++extra) {
    reached[Crc16(kPayloadCrc).update(static_cast<std::uint8_t>(extra)).value()] = true;
  }
  for (unsigned received = 0; received < 65536; ++received) {
    ASSERT_EQ(has_fitting_crc_extra(kPayloadCrc, static_cast<std::uint16_t>(received)),
              reached[received]);
  }
}

}  // namespace
}  // namespace cas::mav::test
