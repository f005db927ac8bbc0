// SPDX-License-Identifier: Apache-2.0
// Fingerprints by which the journal names certificates and revocation lists: the beginning of the
// SHA-256 of each, as `openssl x509 -fingerprint -sha256` and `openssl crl -fingerprint -sha256`
// print it.
#pragma once

#include <string>
#include <vector>

#include "io/tls/openssl_handles.hpp"

namespace mbgate::io {

/// "1A:2B:3C:4D:5E:6F:70:81".
std::string fingerprint(const X509& certificate);
/// Of all of them, with "and" between.
std::string fingerprints(const std::vector<CertificateHandle>& certificates);
/// "2026-11-28 07:12:31 UTC, 3 revoked, 1A:2B:...": when it was made, and how many it names.
std::string lists_text(const std::vector<CrlHandle>& lists);

}  // namespace mbgate::io
