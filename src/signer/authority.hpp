// SPDX-License-Identifier: Apache-2.0
// Whether a key is an authority's. Whoever signs with that one makes certificates of any role, so
// it is no key for a gateway.
#pragma once

#include <openssl/evp.h>

#include <filesystem>
#include <string_view>

namespace mbgate::signer {

/// A file of `folder` with the certificate of an authority that has this key; empty: there is none.
/// It is looked for in files whose names end as those of certificates do, and in `key_file`. A
/// file that cannot be read is named in the journal; a folder need not be there.
std::filesystem::path authority_certificate(const std::filesystem::path& folder,
                                            std::string_view key_file, EVP_PKEY* key);

}  // namespace mbgate::signer
