// SPDX-License-Identifier: Apache-2.0
#include "io/tls/fingerprint.hpp"

#include <openssl/evp.h>

#include <algorithm>
#include <array>
#include <ctime>
#include <fmt/chrono.h>
#include <span>

#include "base/assert.hpp"
#include "base/text.hpp"
#include "sys/openssl.hpp"

namespace mbgate::io {
namespace {

/// Enough to tell one from another.
constexpr std::size_t kShown = 8;

using Digest = std::array<unsigned char, EVP_MAX_MD_SIZE>;

std::string hex_pairs(const Digest& digest, std::size_t size) {
  return fmt::format("{:02X}", fmt::join(std::span(digest).first(std::min(size, kShown)), ":"));
}

std::string made_at(const X509_CRL& list) {
  std::tm parts{};
  if (ASN1_TIME_to_tm(X509_CRL_get0_lastUpdate(&list), &parts) != 1) {
    return "";
  }
  return fmt::format("{:%Y-%m-%d %H:%M:%S} UTC, ", parts);
}

std::string list_text(X509_CRL& list) {
  Digest digest{};
  unsigned size = 0;
  X509_CRL_digest(&list, EVP_sha256(), digest.data(), &size);
  const STACK_OF(X509_REVOKED)* const revoked = X509_CRL_get_REVOKED(&list);
  const int count = revoked == nullptr ? 0 : sk_X509_REVOKED_num(revoked);
  return fmt::format("{}{} revoked, {}", made_at(list), count, hex_pairs(digest, size));
}

}  // namespace

std::string fingerprint(const X509& certificate) {
  Digest digest{};
  unsigned size = 0;
  X509_digest(&certificate, EVP_sha256(), digest.data(), &size);
  return hex_pairs(digest, size);
}

std::string fingerprints(const std::vector<sys::CertificateHandle>& certificates) {
  return joined(
      certificates, [](const auto& it) { return fingerprint(*it); }, " and ");
}

std::string lists_text(const std::vector<sys::CrlHandle>& lists) {
  const auto text = joined(
      lists, [](const auto& it) { return list_text(*it); }, " and ");
  return text.empty() ? "none" : text;
}

std::string sha256(std::string_view text) {
  Digest digest{};
  unsigned size = 0;
  const int done =
      EVP_Digest(text.data(), text.size(), digest.data(), &size, EVP_sha256(), nullptr);
  MBGATE_ASSERT(done == 1, "OpenSSL has SHA-256");
  return fmt::format("{:02x}", fmt::join(std::span(digest).first(size), ""));
}

}  // namespace mbgate::io
