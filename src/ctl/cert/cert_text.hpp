// SPDX-License-Identifier: Apache-2.0
// What the operator is told about certificates: what is in them, and which file goes where.
#pragma once

#include <string>

#include "ctl/cert/cert_request.hpp"
#include "ctl/cert/certificate.hpp"

namespace mbgate::ctl {

/// Subject, role, issuer, validity and what else a certificate says, a line each.
std::string describe(const X509& certificate, Seconds now);
/// Issuer, when the list is to be renewed, and who is on it.
std::string describe(X509_CRL& list, Seconds now);

/// The role in the first certificate of a file: "operator" in quotes, or "none: ..."; empty where
/// the file cannot be read.
std::string role_in_file(const std::filesystem::path& file);

/// Where the files of a new certificate go, and what is to be protected.
std::string advice_after(const MakeAuthority& made);
std::string advice_after(const MakeServer& made);
std::string advice_after(const MakeClient& made);
/// Where a new list goes.
std::string advice_after_list(const std::filesystem::path& folder);

}  // namespace mbgate::ctl
