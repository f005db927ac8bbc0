// SPDX-License-Identifier: Apache-2.0
// Checks what may be signed: digests of SHA-256, SHA-384 or SHA-512, padded as TLS pads them. On
// other bytes, a private RSA key would decrypt, or sign something that only looks like a digest.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "base/signing.hpp"

namespace mbgate::signer {

using Octets = std::vector<std::uint8_t>;

/// Why these bytes must not be signed so, in words that begin with what is expected; empty: they
/// may. `modulus_bits`: of a key of RSA.
std::string_view objection_to_signing(signing::Question how, std::span<const std::uint8_t> bytes,
                                      int modulus_bits);

}  // namespace mbgate::signer
