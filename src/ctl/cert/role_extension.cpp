// SPDX-License-Identifier: Apache-2.0
#include "ctl/cert/role_extension.hpp"

#include <openssl/asn1.h>
#include <openssl/objects.h>

#include <vector>

#include "routing/role_extension.hpp"

namespace mbgate::ctl {
namespace {

using Object = std::unique_ptr<ASN1_OBJECT, openssl::Free<ASN1_OBJECT_free>>;
using Text = std::unique_ptr<ASN1_UTF8STRING, openssl::Free<ASN1_UTF8STRING_free>>;

/// Is it UTF-8 throughout, without control characters?
bool is_printable(const std::string& text) {
  // NOLINTNEXTLINE(cppcoreguidelines-pro-type-reinterpret-cast): OpenSSL has bytes without a sign
  const auto* at = reinterpret_cast<const unsigned char*>(text.data());
  auto left = static_cast<int>(text.size());
  while (left > 0) {
    unsigned long character = 0;
    const int length = UTF8_getc(at, left, &character);
    const bool is_control = character < 0x20 || (character >= 0x7F && character < 0xA0);
    if (length <= 0 || is_control) {
      return false;
    }
    at += length;
    left -= length;
  }
  return true;
}

}  // namespace

std::string wrong_role(const std::string& role) {
  if (role.empty()) {
    return "a role is a text of at least one character; without --role the certificate has the "
           "NULL role, which rules write as \"\"";
  }
  if (role.size() > routing::kLongestRole || !is_printable(role)) {
    return "a role is UTF-8 text without control characters, of at most " +
           std::to_string(routing::kLongestRole) + " bytes";
  }
  return {};
}

void add_role(X509& certificate, const std::string& role) {
  const Text text(openssl::expect(ASN1_UTF8STRING_new()));
  openssl::expect(ASN1_STRING_set(text.get(), role.data(), static_cast<int>(role.size())));
  unsigned char* bytes = nullptr;
  const int size = i2d_ASN1_UTF8STRING(text.get(), &bytes);
  openssl::expect(size);
  const std::unique_ptr<ASN1_OCTET_STRING, openssl::Free<ASN1_OCTET_STRING_free>> value(
      openssl::expect(ASN1_OCTET_STRING_new()));
  ASN1_STRING_set0(value.get(), bytes, size);
  const Object kind(openssl::expect(OBJ_txt2obj(routing::kRoleExtension, 1)));
  const std::unique_ptr<X509_EXTENSION, openssl::Free<X509_EXTENSION_free>> extension(
      openssl::expect(X509_EXTENSION_create_by_OBJ(nullptr, kind.get(), 0, value.get())));
  openssl::expect(X509_add_ext(&certificate, extension.get(), -1));
}

routing::ClientRole read_role(const X509& certificate) {
  const Object kind(openssl::expect(OBJ_txt2obj(routing::kRoleExtension, 1)));
  std::vector<modbus::Bytes> values;
  for (int at = X509_get_ext_by_OBJ(&certificate, kind.get(), -1); at >= 0;
       at = X509_get_ext_by_OBJ(&certificate, kind.get(), at)) {
    const ASN1_OCTET_STRING* const value = X509_EXTENSION_get_data(X509_get_ext(&certificate, at));
    values.emplace_back(ASN1_STRING_get0_data(value),
                        static_cast<std::size_t>(ASN1_STRING_length(value)));
  }
  return routing::role_of(values);
}

}  // namespace mbgate::ctl
