// SPDX-License-Identifier: Apache-2.0
// Certificates and lists of revoked ones, read from files in PEM and taken into use.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "modbus/result.hpp"
#include "sys/openssl.hpp"

namespace mbgate::io {

/// All certificates of the file, one at least; or why not, with the path.
Result<std::vector<sys::CertificateHandle>, std::string> read_certificates(const std::string& path);
/// All lists of the file, one at least; or why not, with the path.
Result<std::vector<sys::CrlHandle>, std::string> read_crls(const std::string& path);

/// Gives the context the first certificate of the file as its own, and those behind it as its
/// chain; or says why not, with the path.
std::optional<std::string> use_certificate(SSL_CTX& context, const std::string& path);

/// Of whom certificates are accepted, and what of them is revoked.
struct Trusted {
  std::vector<sys::CertificateHandle> authorities;
  std::vector<sys::CrlHandle> lists{};  ///< none: nothing is known of that
};

/// Makes the context accept what the authorities of the one file have signed, but not what the
/// lists of the other one name; an empty path: there are no lists. Else there must be one of each
/// authority: OpenSSL accepts no chain with one whose list is missing, and so perhaps nobody. What
/// was read; or why not, with the path.
Result<Trusted, std::string> use_authorities(SSL_CTX& context, const std::string& authorities,
                                             const std::string& crl);

/// For SSL_CTX_set_verify(3). A list that has expired still names revoked certificates: nobody is
/// locked out because it was not renewed, and the journal tells. All other objections count.
int accept_expired_list(int good, X509_STORE_CTX* store);

}  // namespace mbgate::io
