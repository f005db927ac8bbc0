// SPDX-License-Identifier: Apache-2.0
#include "ctl/tls/certificate_role.hpp"

#include <openssl/objects.h>
#include <openssl/pem.h>

#include <memory>
#include <vector>

#include "ctl/tls/openssl.hpp"
#include "ctl/visible_text.hpp"
#include "routing/role_extension.hpp"

namespace mbgate::ctl {
namespace {

using Certificate = std::unique_ptr<X509, openssl::Free<X509_free>>;
using File = std::unique_ptr<BIO, openssl::Free<BIO_free_all>>;
using Object = std::unique_ptr<ASN1_OBJECT, openssl::Free<ASN1_OBJECT_free>>;

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

}  // namespace

std::string role_in_file(const std::filesystem::path& file) {
  const File input(BIO_new_file(file.c_str(), "r"));
  const Certificate certificate(input ? PEM_read_bio_X509(input.get(), nullptr, nullptr, nullptr)
                                      : nullptr);
  if (!certificate) {
    static_cast<void>(openssl::last_error());
    return {};
  }
  const auto role = read_role(*certificate);
  if (role.kind == routing::ClientRole::Kind::unreadable) {
    return "unreadable: a gateway answers every request with exception 01";
  }
  std::string text = "\"";
  for (const char it : visible_text(role.name)) {
    text.append(it == '"' || it == '\\' ? "\\" : "").push_back(it);
  }
  return role.name.empty() ? "none: the NULL role, which rules write as \"\"" : text + "\"";
}

}  // namespace mbgate::ctl
