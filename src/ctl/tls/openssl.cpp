// SPDX-License-Identifier: Apache-2.0
#include "ctl/tls/openssl.hpp"

#include <openssl/err.h>

#include <system_error>

namespace mbgate::ctl::openssl {

std::string last_error() {
  unsigned long last = 0;
  int system_error = 0;
  while (const unsigned long error = ERR_get_error()) {
    last = error;
    system_error = ERR_SYSTEM_ERROR(error) ? ERR_GET_REASON(error) : system_error;
  }
  if (system_error != 0) {  // of which those behind it say only that there was one
    return std::generic_category().message(system_error);
  }
  const char* const reason = ERR_reason_error_string(last);
  return reason == nullptr ? "unknown error" : reason;
}

void expect(int done) {
  if (done <= 0) {
    throw Failure("OpenSSL: " + last_error());
  }
}

}  // namespace mbgate::ctl::openssl
