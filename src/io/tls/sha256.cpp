// SPDX-License-Identifier: Apache-2.0
#include "io/tls/sha256.hpp"

#include <openssl/evp.h>

#include <array>
#include <memory>

#include "base/assert.hpp"
#include "sys/openssl.hpp"

namespace mbgate::io {
namespace {

constexpr std::size_t kSize = 32;

}  // namespace

std::string sha256(std::span<const std::string_view> texts) {
  const std::unique_ptr<EVP_MD_CTX, sys::FreeWith<EVP_MD_CTX_free>> context(EVP_MD_CTX_new());
  bool good = context && EVP_DigestInit_ex(context.get(), EVP_sha256(), nullptr) == 1;
  for (const std::string_view text : texts) {
    good = good && EVP_DigestUpdate(context.get(), text.data(), text.size()) == 1;
  }
  std::array<unsigned char, kSize> digest{};
  good = good && EVP_DigestFinal_ex(context.get(), digest.data(), nullptr) == 1;
  MBGATE_ASSERT(good, "OpenSSL has SHA-256");
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::string hex;
  for (const unsigned char byte : digest) {
    hex += kDigits[byte >> 4U];
    hex += kDigits[byte & 0xFU];
  }
  return hex;
}

std::string sha256(std::string_view text) { return sha256(std::span(&text, 1)); }

}  // namespace mbgate::io
