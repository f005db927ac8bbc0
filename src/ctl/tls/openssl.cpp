// SPDX-License-Identifier: Apache-2.0
#include "ctl/tls/openssl.hpp"

#include <openssl/err.h>

#include <system_error>

namespace mbgate::ctl::openssl {

std::string last_error() {
  const unsigned long error = ERR_peek_last_error();
  ERR_clear_error();
  if (ERR_SYSTEM_ERROR(error)) {
    return std::generic_category().message(ERR_GET_REASON(error));
  }
  const char* const reason = ERR_reason_error_string(error);
  return reason == nullptr ? "unknown error" : reason;
}

void expect(int done) {
  if (done <= 0) {
    throw Failure("OpenSSL: " + last_error());
  }
}

}  // namespace mbgate::ctl::openssl
