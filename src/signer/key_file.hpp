// SPDX-License-Identifier: Apache-2.0
// A private key out of the folder of keys, and what it is good for: to hand out its public half,
// and to sign.
#pragma once

#include <openssl/evp.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/signing.hpp"

namespace mbgate::signer {

using Octets = std::vector<std::uint8_t>;

class KeyFile {
 public:
  /// What open() came to: the key, or why there is none, in one line.
  struct Opened;

  /// Opens a file of this folder, which `folder` is a descriptor of. Refused: a name with '/' or a
  /// '.' in front, links, what is no ordinary file, what group or others may write or others may
  /// read, and what is no RSA or EC key without a password.
  static Opened open(int folder, std::string_view name);

  /// A SubjectPublicKeyInfo in DER.
  [[nodiscard]] Octets public_key() const;
  /// Nothing if the question does not fit the key, or its bytes do not.
  [[nodiscard]] std::optional<Octets> sign(signing::Question how,
                                           std::span<const std::uint8_t> bytes) const;

 private:
  struct Free {
    void operator()(EVP_PKEY* key) const { EVP_PKEY_free(key); }
  };
  explicit KeyFile(EVP_PKEY* key) : key_(key) {}
  static std::optional<KeyFile> read(std::string_view pem);

  std::unique_ptr<EVP_PKEY, Free> key_;
};

struct KeyFile::Opened {
  std::optional<KeyFile> key;
  std::string why;
};

}  // namespace mbgate::signer
