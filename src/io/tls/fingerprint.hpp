// SPDX-License-Identifier: Apache-2.0
// Fingerprints by which the journal names certificates and revocation lists: the beginning of the
// SHA-256 of each, as `openssl x509 -fingerprint -sha256` and `openssl crl -fingerprint -sha256`
// print it.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "sys/openssl.hpp"

namespace mbgate::io {

/// "1A:2B:3C:4D:5E:6F:70:81".
std::string fingerprint(const X509& certificate);
/// Of all of them, with "and" between.
std::string fingerprints(const std::vector<sys::CertificateHandle>& certificates);
/// "2026-11-28 07:12:31 UTC, 3 revoked, 1A:2B:...": when it was made, and how many it names.
std::string lists_text(const std::vector<sys::CrlHandle>& lists);

/// SHA-256 (FIPS 180-4) of a text: 64 hexadecimal digits in lower case, as sha256sum(1) has them.
std::string sha256(std::string_view text);

}  // namespace mbgate::io
