// SPDX-License-Identifier: Apache-2.0
#include "sys/openssl.hpp"

#include <stdexcept>
#include <system_error>

namespace mbgate::sys {

void raise_own_error(const std::string& why) {
  ERR_raise_data(ERR_LIB_USER, ERR_R_OPERATION_FAIL, "%s", why.c_str());
}

std::string take_openssl_error() {
  const unsigned long newest = ERR_peek_last_error();
  const char* data = nullptr;
  int flags = 0;
  int system_error = 0;
  while (const unsigned long error = ERR_get_error_all(nullptr, nullptr, nullptr, &data, &flags)) {
    if (ERR_GET_LIB(error) == ERR_LIB_USER && (flags & ERR_TXT_STRING) != 0) {
      std::string why = data;
      ERR_clear_error();
      return why;
    }
    system_error = ERR_SYSTEM_ERROR(error) ? ERR_GET_REASON(error) : system_error;
  }
  if (system_error != 0) {
    return std::generic_category().message(system_error);
  }
  const char* const reason = ERR_reason_error_string(newest);
  return reason != nullptr ? reason
         : newest == 0     ? "no reason is known"
                           : "error " + std::to_string(newest);
}

void expect_openssl(int done) {
  if (done <= 0) {
    throw std::runtime_error("OpenSSL: " + take_openssl_error());
  }
}

std::vector<std::span<const std::uint8_t>> extensions_of(const X509& certificate,
                                                         const char* kind) {
  const std::unique_ptr<ASN1_OBJECT, FreeWith<ASN1_OBJECT_free>> wanted(OBJ_txt2obj(kind, 1));
  std::vector<std::span<const std::uint8_t>> values;
  for (int at = X509_get_ext_by_OBJ(&certificate, wanted.get(), -1); at >= 0;
       at = X509_get_ext_by_OBJ(&certificate, wanted.get(), at)) {
    const ASN1_OCTET_STRING* const value = X509_EXTENSION_get_data(X509_get_ext(&certificate, at));
    values.emplace_back(ASN1_STRING_get0_data(value),
                        static_cast<std::size_t>(ASN1_STRING_length(value)));
  }
  return values;
}

}  // namespace mbgate::sys
