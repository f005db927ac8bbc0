// SPDX-License-Identifier: Apache-2.0
// Certificates and lists of revoked ones, read from files in PEM.
#pragma once

#include <string>
#include <vector>

#include "io/tls/openssl_handles.hpp"
#include "modbus/result.hpp"

namespace mbgate::io {

/// All certificates of the file, one at least; or why not, with the path.
Result<std::vector<CertificateHandle>, std::string> read_certificates(const std::string& path);
/// All lists of the file, one at least; or why not, with the path.
Result<std::vector<CrlHandle>, std::string> read_crls(const std::string& path);

}  // namespace mbgate::io
