// SPDX-License-Identifier: Apache-2.0
// Objects of OpenSSL with an owner, and its errors as text.
#pragma once

#include <openssl/err.h>
#include <openssl/evp.h>
#include <openssl/ssl.h>
#include <openssl/x509.h>

#include <memory>
#include <string>

namespace mbgate::io {

template <auto Free>
struct FreeWith {
  template <typename Object>
  void operator()(Object* object) const {
    Free(object);
  }
};

inline void free_certificates(STACK_OF(X509) * certificates) {
  sk_X509_pop_free(certificates, X509_free);
}

using KeyHandle = std::unique_ptr<EVP_PKEY, FreeWith<EVP_PKEY_free>>;
using BioHandle = std::unique_ptr<BIO, FreeWith<BIO_free>>;
using CertificateHandle = std::unique_ptr<X509, FreeWith<X509_free>>;
using CrlHandle = std::unique_ptr<X509_CRL, FreeWith<X509_CRL_free>>;
using ChainHandle = std::unique_ptr<STACK_OF(X509), FreeWith<free_certificates>>;
using ContextHandle = std::unique_ptr<SSL_CTX, FreeWith<SSL_CTX_free>>;
using SslHandle = std::unique_ptr<SSL, FreeWith<SSL_free>>;
using SessionHandle = std::unique_ptr<SSL_SESSION, FreeWith<SSL_SESSION_free>>;

/// An error of ours, within a function that OpenSSL calls.
inline void raise_own_error(const std::string& why) {
  ERR_raise_data(ERR_LIB_USER, ERR_R_OPERATION_FAIL, "%s", why.c_str());
}

/// What OpenSSL says of the newest error of this thread, all of which it then forgets; but if one
/// is ours, what we said of that: OpenSSL adds to it that the call of a library has failed.
inline std::string take_openssl_error() {
  const unsigned long error = ERR_peek_last_error();
  const char* data = nullptr;
  int flags = 0;
  while (const unsigned long older = ERR_get_error_all(nullptr, nullptr, nullptr, &data, &flags)) {
    if (ERR_GET_LIB(older) == ERR_LIB_USER && (flags & ERR_TXT_STRING) != 0) {
      std::string why = data;
      ERR_clear_error();
      return why;
    }
  }
  const char* const reason = ERR_reason_error_string(error);
  ERR_clear_error();
  return reason != nullptr ? reason
         : error == 0      ? "no reason is known"
                           : "error " + std::to_string(error);
}

}  // namespace mbgate::io
