// SPDX-License-Identifier: Apache-2.0
// Objects of OpenSSL that free themselves, and its errors in words.
#pragma once

#include <openssl/bio.h>
#include <openssl/evp.h>
#include <openssl/ssl.h>
#include <openssl/x509.h>

#include <memory>
#include <stdexcept>
#include <string>

namespace mbgate::ctl::openssl {

template <auto Function>
struct Free {
  template <typename Object>
  void operator()(Object* object) const {
    Function(object);
  }
};

using Context = std::unique_ptr<SSL_CTX, Free<SSL_CTX_free>>;
using Session = std::unique_ptr<SSL, Free<SSL_free>>;

/// What fails for want of memory or of a sound OpenSSL, and by nothing that a user gave.
class Failure : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The reason of the last error in OpenSSL's words; none is left behind it.
std::string last_error();

/// Throws Failure unless OpenSSL says that it was done.
void expect(int done);

/// Throws Failure if OpenSSL gave nothing.
template <typename Object>
Object* expect(Object* object) {
  expect(object != nullptr ? 1 : 0);
  return object;
}

}  // namespace mbgate::ctl::openssl
