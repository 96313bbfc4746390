// SPDX-License-Identifier: BSD-3-Clause
#include "mavlink_gen/runtime/sha256.hpp"

#include <gtest/gtest.h>

#include <random>
#include <string>
#include <vector>

namespace {

using namespace cas::mav;

std::string hex(const Sha256Digest& digest) {
  std::string out;
  for (const auto byte : digest) {
    out += "0123456789abcdef"[byte >> 4U];
    out += "0123456789abcdef"[byte & 15U];
  }
  return out;
}

template <class Hash>
std::string hash_of(std::string_view text) {
  Hash hash;
  hash.update({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
  return hex(hash.finish());
}

TEST(Sha256Vectors, MatchTheStandard) {
  struct HashCase {
    const char* name;
    std::string text;
    const char* digest;
  };
  const HashCase rows[] = {
      {"Empty", "", "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855"},
      {"OneBlock", "abc", "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"},
      {"TwoBlocks", "abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq",
       "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1"},
      {"AMillionLetters", std::string(1'000'000, 'a'),
       "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0"}};
  for (const auto& [name, text, digest] : rows) {
    SCOPED_TRACE(name);
    EXPECT_EQ(hash_of<BasicSha256<Sha256Portable>>(text), digest);
    EXPECT_EQ(hash_of<Sha256>(text), digest);
  }
}

TEST(Sha256, IsTheSameHoweverTheBytesComeAndWhateverComputesIt) {
  std::mt19937 random(3);
  for (std::size_t size = 0; size < 300; ++size) {
    std::vector<std::uint8_t> bytes(size);
    for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random());
    const auto whole = Sha256().update(bytes).finish();
    BasicSha256<Sha256Portable> pieces;
    for (std::size_t i = 0; i < size;) {
      const auto piece = std::min<std::size_t>(1 + random() % 100, size - i);
      pieces.update(std::span(bytes).subspan(i, piece));
      i += piece;
    }
    ASSERT_EQ(hex(pieces.finish()), hex(whole)) << size;
  }
}

}  // namespace
