// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>

#include "base/export.hpp"

namespace cas::base::rpc {

/// End that proves its knowledge of the token: the proof of one is of no use to the other.
enum class Prover { kServer, kClient };

/// The values that a proof is bound to. Both nonces are fresh in each connection.
struct ProofContext {
  /// The server's end of the connection as both ends see it (server_endpoint()): a program at
  /// another address cannot pass the proofs on.
  std::string endpoint;
  std::string client_nonce;
  std::string server_nonce;
};

/// Proof that its maker knows the token, which it does not tell: HMAC-SHA-256 [RFC 2104] with the
/// token as its key, in hexadecimal digits, over the lines "cas", "server" or "client", the
/// endpoint, the client's and the server's nonce, each ended by a newline.
CAS_BASE_EXPORT std::string token_proof(std::string_view token, Prover prover,
                                        const ProofContext& context);

/// HMAC-SHA-256 in hexadecimal digits.
CAS_BASE_EXPORT std::string hmac_sha256(std::string_view key, std::string_view text);

/// 256 random bits of the kernel in hexadecimal digits. @throws ConfigError when it gives none
CAS_BASE_EXPORT std::string make_nonce();

/// The server's end of a TCP connection, "127.0.0.1:5790" or "[::1]:5790"; an IPv4 address that an
/// IPv6 socket sees is written as IPv4. Empty for other sockets.
/// @param connected  the socket @param prover  at which end this is
CAS_BASE_EXPORT std::string server_endpoint(int connected, Prover prover);

}  // namespace cas::base::rpc
