// SPDX-License-Identifier: Apache-2.0
// The list of certificates that an authority has revoked (CRL). It is all that is kept of them: a
// new list is the old one, with its number raised, and signed again.
#pragma once

#include "ctl/cert/certificate.hpp"

namespace mbgate::ctl {

/// The list after `old`, an empty one after nothing. It is to be renewed within `days`.
openssl::RevocationList next_list(const Authority& authority, X509_CRL* old, unsigned days);

/// Has this authority signed it?
bool is_list_of(X509_CRL& list, const Authority& authority);

/// When a certificate was revoked, if it was.
std::optional<Seconds> revoked_at(X509_CRL& list, X509& certificate);

/// Adds a certificate to a list and signs it again.
void revoke(X509_CRL& list, X509& certificate, const Authority& authority);

/// How many certificates are on it.
std::size_t revoked_count(X509_CRL& list);

}  // namespace mbgate::ctl
