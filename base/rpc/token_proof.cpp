// SPDX-License-Identifier: BSD-3-Clause
#include "base/rpc/token_proof.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/random.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <span>

#include "base/error.hpp"
#include "mavlink_gen/runtime/sha256.hpp"

namespace cas::base::rpc {
namespace {

constexpr std::size_t kNonceBytes = 32;

std::span<const std::uint8_t> bytes_of(std::string_view text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

std::string hexadecimal(std::span<const std::uint8_t> bytes) {
  std::string text;
  for (const std::uint8_t byte : bytes) {
    text += "0123456789abcdef"[byte >> 4U];
    text += "0123456789abcdef"[byte & 15U];
  }
  return text;
}

using Block = std::array<std::uint8_t, mav::kSha256BlockBytes>;

Block key_block(std::string_view key) {
  Block block{};
  if (key.size() > block.size()) {
    const mav::Sha256Digest digest = mav::Sha256().update(bytes_of(key)).finish();
    std::copy(digest.begin(), digest.end(), block.begin());
  } else {
    std::copy(key.begin(), key.end(), block.begin());
  }
  return block;
}

Block masked(Block block, std::uint8_t mask) {
  for (std::uint8_t& byte : block) byte = static_cast<std::uint8_t>(byte ^ mask);
  return block;
}

std::string v4_text(const in_addr& address, std::uint16_t port) {
  std::array<char, INET_ADDRSTRLEN> text{};
  ::inet_ntop(AF_INET, &address, text.data(), text.size());
  return std::string(text.data()) + ":" + std::to_string(ntohs(port));
}

std::string v6_text(const sockaddr_in6& address) {
  if (IN6_IS_ADDR_V4MAPPED(&address.sin6_addr)) {
    in_addr v4{};
    std::memcpy(&v4, address.sin6_addr.s6_addr + 12, sizeof v4);
    return v4_text(v4, address.sin6_port);
  }
  std::array<char, INET6_ADDRSTRLEN> text{};
  ::inet_ntop(AF_INET6, &address.sin6_addr, text.data(), text.size());
  return "[" + std::string(text.data()) + "]:" + std::to_string(ntohs(address.sin6_port));
}

}  // namespace

std::string hmac_sha256(std::string_view key, std::string_view text) {
  const Block block = key_block(key);
  const Block inner = masked(block, 0x36);
  const Block outer = masked(block, 0x5c);
  const mav::Sha256Digest digest = mav::Sha256().update(inner).update(bytes_of(text)).finish();
  return hexadecimal(mav::Sha256().update(outer).update(digest).finish());
}

std::string token_proof(std::string_view token, Prover prover, const ProofContext& context) {
  std::string text = "cas\n";
  text += prover == Prover::kServer ? "server\n" : "client\n";
  for (const std::string* line :
       {&context.endpoint, &context.client_nonce, &context.server_nonce}) {
    text += *line + "\n";
  }
  return hmac_sha256(token, text);
}

std::string make_nonce() {
  std::array<std::uint8_t, kNonceBytes> random{};
  if (::getrandom(random.data(), random.size(), 0) != static_cast<ssize_t>(random.size())) {
    throw ConfigError("the kernel gave no random bits");
  }
  return hexadecimal(random);
}

std::string server_endpoint(int connected, Prover prover) {
  sockaddr_storage address{};
  socklen_t size = sizeof address;
  auto* const generic = reinterpret_cast<sockaddr*>(&address);
  const int failed = prover == Prover::kServer ? ::getsockname(connected, generic, &size)
                                               : ::getpeername(connected, generic, &size);
  if (failed != 0) return "";
  if (address.ss_family == AF_INET) {
    const auto& v4 = reinterpret_cast<const sockaddr_in&>(address);
    return v4_text(v4.sin_addr, v4.sin_port);
  }
  return address.ss_family == AF_INET6 ? v6_text(reinterpret_cast<const sockaddr_in6&>(address))
                                       : "";
}

}  // namespace cas::base::rpc
