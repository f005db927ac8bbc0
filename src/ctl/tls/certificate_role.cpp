// SPDX-License-Identifier: Apache-2.0
#include "ctl/tls/certificate_role.hpp"

#include <openssl/pem.h>

#include "ctl/visible_text.hpp"
#include "routing/role_extension.hpp"
#include "sys/openssl.hpp"

namespace mbgate::ctl {
std::string role_in_file(const std::filesystem::path& file) {
  const sys::BioHandle input(BIO_new_file(file.c_str(), "r"));
  const sys::CertificateHandle certificate(
      input ? PEM_read_bio_X509(input.get(), nullptr, nullptr, nullptr) : nullptr);
  if (!certificate) {
    ERR_clear_error();
    return {};
  }
  const auto role = routing::role_of(sys::extensions_of(*certificate, routing::kRoleExtension));
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
