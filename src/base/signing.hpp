// SPDX-License-Identifier: Apache-2.0
// The protocol between mbgated and mbgate-signer, over a Unix socket of whole messages
// (SOCK_SEQPACKET). Each question is one message and gets one answer. The first byte says what it
// is, the rest belongs to it. A connection has one key: it must be opened before anything is
// signed, and opening it again reads the file again.
#pragma once

#include <cstddef>
#include <cstdint>

namespace mbgate::signing {

enum class Question : std::uint8_t {
  open = 'K',        ///< the name of a file in the folder of keys
  rsa_pkcs1 = 'P',   ///< an encoded digest (RFC 8017, 9.2, note 1); RSASSA-PKCS1-v1_5 pads it
  rsa_padded = 'N',  ///< as many bytes as the modulus has, padded already (RSASSA-PSS)
  ecdsa = 'E',       ///< a digest
};

enum class Answer : std::uint8_t {
  opened = 'K',  ///< the public key, a SubjectPublicKeyInfo in DER
  signature = 'S',
  refused = 'F',  ///< why, one line of text
};

/// Room for the name of a file, a signature and a public key of RSA with 8192 bits.
inline constexpr std::size_t kLargestMessage = 2048;

}  // namespace mbgate::signing
