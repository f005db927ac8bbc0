// SPDX-License-Identifier: Apache-2.0
// A private key from the folder of keys. It can give its public half, and sign digests.
#pragma once

#include <openssl/evp.h>

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/signing.hpp"
#include "signer/padding.hpp"
#include "sys/openssl.hpp"

namespace mbgate::signer {

/// Which keys may be used.
struct KeyStore {
  std::string folder;
  std::vector<std::string> names;  ///< of its files, or patterns of them (glob(7))
  std::string certificates;        ///< a folder; those of authorities are looked for in both
};

class KeyFile {
 public:
  /// What open() came to: the key, or why there is none, in one line.
  struct Opened;

  /// Opens a file of the store. Refused: a name that is not the store's, one with '/' or a '.' in
  /// front, links, what is no ordinary file, what group or others may write or others may read,
  /// what is no RSA or EC key without a password, and the key of an authority.
  static Opened open(const KeyStore& store, const std::string& name);

  /// That of the file.
  [[nodiscard]] const std::string& name() const { return name_; }

  /// A SubjectPublicKeyInfo in DER.
  [[nodiscard]] Octets public_key() const;
  /// Why this must not be signed with this key (objection_to_signing()); empty: it may.
  [[nodiscard]] std::string_view objection(signing::Question how,
                                           std::span<const std::uint8_t> bytes) const;
  /// Only without objection. Nothing if OpenSSL does not sign it.
  [[nodiscard]] std::optional<Octets> sign(signing::Question how,
                                           std::span<const std::uint8_t> bytes) const;

 private:
  KeyFile(sys::KeyHandle key, std::string name) : key_(std::move(key)), name_(std::move(name)) {}
  static std::optional<KeyFile> read(std::string_view pem, const std::string& name);
  [[nodiscard]] bool is_rsa() const { return EVP_PKEY_get_base_id(key_.get()) == EVP_PKEY_RSA; }

  sys::KeyHandle key_;
  std::string name_;
};

struct KeyFile::Opened {
  std::optional<KeyFile> key;
  std::string why;
};

// Whether a key is an authority's. Whoever signs with that one makes certificates of any role, so
// it is no key for a gateway.

/// A file of `folder` with the certificate of an authority that has this key; empty: there is none.
/// It is looked for in files whose names end as those of certificates do, and in `key_file`. A
/// file that cannot be read is named in the journal; a folder need not be there.
std::filesystem::path authority_certificate(const std::filesystem::path& folder,
                                            std::string_view key_file, EVP_PKEY* key);

}  // namespace mbgate::signer
