// SPDX-License-Identifier: BSD-3-Clause
// Proof that an end of the connection knows the token of the address, which neither tells (base/rpc/token_proof.hpp).
// Without crypto.subtle: over plain HTTP a browser has it for this machine's own addresses alone.
import {hmac} from '@noble/hashes/hmac.js';
import {sha256} from '@noble/hashes/sha2.js';
import {bytesToHex, randomBytes, utf8ToBytes} from '@noble/hashes/utils.js';

/** 256 random bits in hexadecimal digits. */
export function makeNonce(): string {
  return bytesToHex(randomBytes(32));
}

/** The values that a proof is bound to: the place where the page was opened and fresh nonces of both ends. */
export interface ProofContext {
  place: string;
  pageNonce: string;
  serverNonce: string;
}

export function tokenProof(token: string, prover: 'server' | 'client', {place, pageNonce, serverNonce}: ProofContext): string {
  const text = ['cas', prover, place, pageNonce, serverNonce].map((line) => `${line}\n`).join('');
  return bytesToHex(hmac(sha256, utf8ToBytes(token), utf8ToBytes(text)));
}
