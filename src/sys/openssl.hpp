// SPDX-License-Identifier: Apache-2.0
// Objects of OpenSSL with an owner, and its errors as text.
#pragma once

#include <openssl/err.h>
#include <openssl/evp.h>
#include <openssl/ssl.h>
#include <openssl/x509.h>

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace mbgate::sys {

template <auto Free>
struct FreeWith {
  template <typename Object>
  void operator()(Object* object) const {
    Free(object);
  }
};

using KeyHandle = std::unique_ptr<EVP_PKEY, FreeWith<EVP_PKEY_free>>;
using KeyUseHandle = std::unique_ptr<EVP_PKEY_CTX, FreeWith<EVP_PKEY_CTX_free>>;
using BioHandle = std::unique_ptr<BIO, FreeWith<BIO_free_all>>;
using CertificateHandle = std::unique_ptr<X509, FreeWith<X509_free>>;
using CrlHandle = std::unique_ptr<X509_CRL, FreeWith<X509_CRL_free>>;
using ContextHandle = std::unique_ptr<SSL_CTX, FreeWith<SSL_CTX_free>>;
using SslHandle = std::unique_ptr<SSL, FreeWith<SSL_free>>;

/// An error of ours, within a function that OpenSSL calls.
void raise_own_error(const std::string& why);

/// What OpenSSL says of the newest error of this thread, all of which it then forgets; but if one
/// is ours or the system's, what was said of that: OpenSSL adds to it that a call has failed.
std::string take_openssl_error();

/// Throws unless OpenSSL says that it was done, which fails for want of memory or of a sound
/// OpenSSL alone.
void expect_openssl(int done);
/// Throws if OpenSSL gave nothing.
template <typename Object>
Object* expect_openssl(Object* object) {
  expect_openssl(object != nullptr ? 1 : 0);
  return object;
}

/// What each extension of this kind (a dotted number) has in it; as long as the certificate is.
std::vector<std::span<const std::uint8_t>> extensions_of(const X509& certificate, const char* kind);

}  // namespace mbgate::sys
