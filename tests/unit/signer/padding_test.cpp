// SPDX-License-Identifier: Apache-2.0
// OpenSSL pads, as it does for mbgated; what is padded otherwise is made from that.
#define OPENSSL_SUPPRESS_DEPRECATED
#include "signer/padding.hpp"

#include <gtest/gtest.h>
#include <openssl/bn.h>
#include <openssl/evp.h>
#include <openssl/rsa.h>

#include <memory>
#include <string>

namespace mbgate::signer::padding_test {
namespace {

using signing::Question;

constexpr std::string_view kPss =
    "expected a digest of SHA-256, SHA-384 or SHA-512 in the padding of PSS (RFC 8017, 9.1)";

struct FreeRsa {
  void operator()(RSA* key) const { RSA_free(key); }
};
using RsaKey = std::unique_ptr<RSA, FreeRsa>;

/// Only its size matters.
RsaKey key_of(int bits) {
  RsaKey key(RSA_new());
  BIGNUM* const modulus = BN_new();
  BIGNUM* const exponent = BN_new();
  BN_set_bit(modulus, bits - 1);
  BN_set_bit(modulus, 0);
  BN_set_word(exponent, RSA_F4);
  RSA_set0_key(key.get(), modulus, exponent, nullptr);
  return key;
}

Octets padded(int bits, const EVP_MD* digest, int salt = RSA_PSS_SALTLEN_DIGEST,
              const EVP_MD* mask = nullptr) {
  const auto key = key_of(bits);
  Octets message(static_cast<std::size_t>(RSA_size(key.get())));
  const Octets hash(static_cast<std::size_t>(EVP_MD_get_size(digest)), 0x5A);
  EXPECT_EQ(1, RSA_padding_add_PKCS1_PSS_mgf1(key.get(), message.data(), hash.data(), digest, mask,
                                              salt));
  return message;
}

std::string_view judged(const Octets& message, int bits = 2048) {
  return objection_to_signing(Question::rsa_padded, message, bits);
}

TEST(Pss, IsKnownWhateverTheSizesOfKeyAndDigest) {
  for (const int bits : {1600, 2041, 2047, 2048, 2049, 2050, 2055, 3072, 4096, 8192}) {
    for (const EVP_MD* digest : {EVP_sha256(), EVP_sha384(), EVP_sha512()}) {
      EXPECT_EQ(judged(padded(bits, digest), bits), "") << bits;
    }
  }
}

TEST(Pss, IsRefusedWithAnyOtherBitInDigestPaddingOrTrailer) {
  const Octets good = padded(2048, EVP_sha256());
  const std::size_t hash = good.size() - 33;
  const std::size_t salt = hash - 32;
  for (std::size_t bit = 0; bit < good.size() * 8; ++bit) {
    if (bit / 8 < salt || bit / 8 >= hash) {
      Octets other = good;
      other[bit / 8] ^= static_cast<std::uint8_t>(0x80U >> (bit % 8));
      EXPECT_EQ(judged(other), kPss) << bit;
    }
  }
}

TEST(Pss, IsRefusedForOtherDigestsSaltsMasksAndKeys) {
  EXPECT_EQ(judged(padded(2048, EVP_sha1())), kPss);
  EXPECT_EQ(judged(padded(2048, EVP_sha224())), kPss);
  EXPECT_EQ(judged(padded(2048, EVP_sha256(), 0)), kPss);
  EXPECT_EQ(judged(padded(2048, EVP_sha256(), 31)), kPss);
  EXPECT_EQ(judged(padded(2048, EVP_sha256(), RSA_PSS_SALTLEN_MAX)), kPss);
  EXPECT_EQ(judged(padded(2048, EVP_sha256(), RSA_PSS_SALTLEN_DIGEST, EVP_sha1())), kPss);
  EXPECT_EQ(judged(padded(2048, EVP_sha256()), 3072), kPss);
  EXPECT_EQ(judged(padded(2049, EVP_sha256()), 2050), kPss);
  for (const std::size_t size : {0, 1, 32, 66, 255, 257}) {
    EXPECT_EQ(judged(Octets(size, 0xBC)), kPss) << size;
  }
  // Keys that are too small for a digest.
  for (int bits = 0; bits < 80; ++bits) {
    EXPECT_EQ(judged(Octets(static_cast<std::size_t>((bits + 7) / 8), 0xBC), bits), kPss) << bits;
  }
}

TEST(Pkcs1, IsTheDigestInfoOfThreeDigestsAndNothingElse) {
  const Octets head = {0x30, 0x31, 0x30, 0x0D, 0x06, 0x09, 0x60, 0x86, 0x48, 0x01,
                       0x65, 0x03, 0x04, 0x02, 0x01, 0x05, 0x00, 0x04, 0x20};
  Octets good = head;
  good.resize(head.size() + 32, 0xA5);
  const auto judged = [](const Octets& bytes) {
    return objection_to_signing(Question::rsa_pkcs1, bytes, 2048);
  };
  EXPECT_EQ(judged(good), "");
  for (std::size_t bit = 0; bit < head.size() * 8; ++bit) {
    Octets other = good;
    other[bit / 8] ^= static_cast<std::uint8_t>(0x80U >> (bit % 8));
    EXPECT_EQ(judged(other),
              "expected the DigestInfo of SHA-256, SHA-384 or SHA-512 (RFC 8017, 9.2)")
        << bit;
  }
  for (const std::size_t size : {0, 19, 20, 32, 36, 50, 52}) {
    Octets other = good;
    other.resize(size);
    EXPECT_NE(judged(other), "") << size;
  }
}

TEST(Ecdsa, IsADigestOfThreeSizes) {
  for (std::size_t size = 0; size < 140; ++size) {
    const bool fits = size == 32 || size == 48 || size == 64;
    EXPECT_EQ(objection_to_signing(Question::ecdsa, Octets(size), 256),
              fits ? "" : "expected a digest of 32, 48 or 64 bytes");
  }
}

TEST(Open, IsNoQuestionForASignature) {
  EXPECT_NE(objection_to_signing(Question::open, Octets(32), 256), "");
}

}  // namespace
}  // namespace mbgate::signer::padding_test
