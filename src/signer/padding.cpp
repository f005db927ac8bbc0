// SPDX-License-Identifier: Apache-2.0
#include "signer/padding.hpp"

#include <openssl/evp.h>

#include <algorithm>
#include <array>

namespace mbgate::signer {
namespace {

using Bytes = std::span<const std::uint8_t>;

struct Hash {
  std::uint8_t size;
  std::uint8_t number;  ///< the last part of its object identifier, 2.16.840.1.101.3.4.2
  const EVP_MD* (*digest)();
};

constexpr std::array<Hash, 3> kHashes{
    {{32, 1, EVP_sha256}, {48, 2, EVP_sha384}, {64, 3, EVP_sha512}}};

bool is_digest_of(const Hash& hash, Bytes bytes) { return bytes.size() == hash.size; }

/// A DigestInfo in DER (RFC 8017, 9.2, note 1).
bool is_digest_info_of(const Hash& hash, Bytes bytes) {
  constexpr std::uint8_t kRestOfHead = 17;
  const std::array<std::uint8_t, kRestOfHead + 2> head{
      0x30,        static_cast<std::uint8_t>(kRestOfHead + hash.size),
      0x30,        0x0D,
      0x06,        0x09,
      0x60,        0x86,
      0x48,        0x01,
      0x65,        0x03,
      0x04,        0x02,
      hash.number, 0x05,
      0x00,        0x04,
      hash.size};
  return bytes.size() == head.size() + hash.size &&
         std::ranges::equal(bytes.first(head.size()), head);
}

/// The mask generation function MGF1 (RFC 8017, B.2.1); nothing if OpenSSL does not digest.
Octets mask_of(Bytes seed, std::size_t size, const Hash& hash) {
  Octets counted(seed.begin(), seed.end());
  counted.resize(seed.size() + sizeof(std::uint32_t));
  Octets mask;
  while (mask.size() < size) {
    Octets piece(hash.size);
    if (EVP_Digest(counted.data(), counted.size(), piece.data(), nullptr, hash.digest(), nullptr) !=
        1) {
      return {};
    }
    mask.insert(mask.end(), piece.begin(), piece.end());
    ++counted.back();  // the largest key of OpenSSL, 16384 bits, takes 64 pieces
  }
  mask.resize(size);
  return mask;
}

/// An encoded message of EMSA-PSS whose salt is as long as the digest, as in TLS (RFC 8017, 9.1.2,
/// steps 3 to 10; RFC 8446, 4.2.3). What was digested cannot be seen in it.
bool is_pss_of(const Hash& hash, Bytes bytes, int modulus_bits) {
  constexpr int kOctet = 8;
  if (modulus_bits <= 0 ||
      bytes.size() != static_cast<std::size_t>(modulus_bits + kOctet - 1) / kOctet) {
    return false;
  }
  const auto bits = static_cast<unsigned>(modulus_bits - 1);
  if (bits % kOctet == 0) {  // the encoded message is an octet shorter than the modulus
    if (bytes.front() != 0) {
      return false;
    }
    bytes = bytes.subspan(1);
  }
  const std::size_t salt = hash.size;
  const std::size_t shortest = salt + hash.size + 2;
  if (bytes.size() < shortest || bytes.back() != 0xBC) {
    return false;
  }
  const std::size_t padded = bytes.size() - hash.size - 1;
  const Octets mask = mask_of(bytes.subspan(padded, hash.size), padded, hash);
  const auto unused = static_cast<std::uint8_t>(bits % kOctet == 0 ? 0 : 0xFF << (bits % kOctet));
  if (mask.empty() || (bytes.front() & unused) != 0) {
    return false;
  }
  Octets data(padded);
  std::ranges::transform(bytes.first(padded), mask, data.begin(), std::bit_xor<std::uint8_t>());
  data.front() &= static_cast<std::uint8_t>(~unused);
  const auto end_of_zeros = data.end() - static_cast<std::ptrdiff_t>(salt) - 1;
  return *end_of_zeros == 1 &&
         std::all_of(data.begin(), end_of_zeros, [](std::uint8_t octet) { return octet == 0; });
}

}  // namespace

std::string_view objection_to_signing(signing::Question how, Bytes bytes, int modulus_bits) {
  const auto any = [](auto fits) { return std::ranges::any_of(kHashes, fits); };
  switch (how) {
    case signing::Question::ecdsa:
      return any([&](const Hash& hash) { return is_digest_of(hash, bytes); })
                 ? ""
                 : "expected a digest of 32, 48 or 64 bytes";
    case signing::Question::rsa_pkcs1:
      return any([&](const Hash& hash) { return is_digest_info_of(hash, bytes); })
                 ? ""
                 : "expected the DigestInfo of SHA-256, SHA-384 or SHA-512 (RFC 8017, 9.2)";
    case signing::Question::rsa_padded:
      return any([&](const Hash& hash) { return is_pss_of(hash, bytes, modulus_bits); })
                 ? ""
                 : "expected a digest of SHA-256, SHA-384 or SHA-512 in the padding of PSS "
                   "(RFC 8017, 9.1)";
    case signing::Question::open: break;
  }
  return "expected a question for a signature";
}

}  // namespace mbgate::signer
