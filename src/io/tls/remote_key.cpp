// SPDX-License-Identifier: Apache-2.0
// The methods of RSA and EC keys are how OpenSSL 3 lets a program sign without a provider of its
// own. They are deprecated in favour of providers, which need many times as much code.
#define OPENSSL_SUPPRESS_DEPRECATED
#include <openssl/ec.h>
#include <openssl/rsa.h>

#include <algorithm>
#include <optional>
#include <span>

#include "io/tls/signer_client.hpp"

namespace mbgate::io {
namespace {

using signing::Question;
using SignerHold = std::shared_ptr<SignerClient>;
using RsaHandle = std::unique_ptr<RSA, sys::FreeWith<RSA_free>>;
using EcHandle = std::unique_ptr<EC_KEY, sys::FreeWith<EC_KEY_free>>;

/// Called when a key goes that holds a signer.
void free_hold(void* /*parent*/, void* held, CRYPTO_EX_DATA* /*data*/, int /*index*/,
               long /*number*/, void* /*argument*/) {
  delete static_cast<SignerHold*>(held);
}

/// A copy of a key has the same signer.
int copy_hold(CRYPTO_EX_DATA* /*to*/, const CRYPTO_EX_DATA* /*from*/, void** held, int /*index*/,
              long /*number*/, void* /*argument*/) {
  if (*held != nullptr) {
    *held = new SignerHold(*static_cast<SignerHold*>(*held));
  }
  return 1;
}

int rsa_index() {
  static const int index =
      CRYPTO_get_ex_new_index(CRYPTO_EX_INDEX_RSA, 0, nullptr, nullptr, copy_hold, free_hold);
  return index;
}

int ec_index() {
  static const int index =
      CRYPTO_get_ex_new_index(CRYPTO_EX_INDEX_EC_KEY, 0, nullptr, nullptr, copy_hold, free_hold);
  return index;
}

/// Nothing: why is the reason that sys::take_openssl_error() gives.
std::optional<Octets> ask(void* held, Question how, std::span<const std::uint8_t> bytes) {
  if (held == nullptr) {
    return std::nullopt;
  }
  auto signature = (*static_cast<SignerHold*>(held))->sign(how, bytes);
  if (!signature) {
    sys::raise_own_error(signature.error());
    return std::nullopt;
  }
  return *std::move(signature);
}

/// As RSA_meth_set_priv_enc(3) wants it: the size of the signature, or -1.
int rsa_sign(int size, const unsigned char* from, unsigned char* to, RSA* rsa, int padding) {
  if (padding != RSA_PKCS1_PADDING && padding != RSA_NO_PADDING) {
    return -1;
  }
  const auto how = padding == RSA_PKCS1_PADDING ? Question::rsa_pkcs1 : Question::rsa_padded;
  const auto signature =
      ask(RSA_get_ex_data(rsa, rsa_index()), how, {from, static_cast<std::size_t>(size)});
  if (!signature || signature->size() != static_cast<std::size_t>(RSA_size(rsa))) {
    return -1;
  }
  std::ranges::copy(*signature, to);
  return static_cast<int>(signature->size());
}

/// Nothing is decrypted with it: no key exchange that is offered needs it.
int rsa_decrypt(int /*size*/, const unsigned char* /*from*/, unsigned char* /*to*/, RSA* /*rsa*/,
                int /*padding*/) {
  return -1;
}

/// As EC_KEY_METHOD_set_sign(3) wants it: 1, or 0.
int ec_sign(int /*type*/, const unsigned char* digest, int size, unsigned char* to,
            unsigned int* to_size, const BIGNUM* /*inverse*/, const BIGNUM* /*product*/,
            EC_KEY* key) {
  const auto signature = ask(EC_KEY_get_ex_data(key, ec_index()), Question::ecdsa,
                             {digest, static_cast<std::size_t>(size)});
  if (!signature || signature->size() > static_cast<std::size_t>(ECDSA_size(key))) {
    return 0;
  }
  std::ranges::copy(*signature, to);
  *to_size = static_cast<unsigned int>(signature->size());
  return 1;
}

const RSA_METHOD* rsa_method() {
  static RSA_METHOD* const method = [] {
    RSA_METHOD* const made = RSA_meth_dup(RSA_PKCS1_OpenSSL());
    RSA_meth_set1_name(made, "mbgate-signer");
    RSA_meth_set_priv_enc(made, rsa_sign);
    RSA_meth_set_priv_dec(made, rsa_decrypt);
    return made;
  }();
  return method;
}

const EC_KEY_METHOD* ec_method() {
  static EC_KEY_METHOD* const method = [] {
    EC_KEY_METHOD* const made = EC_KEY_METHOD_new(EC_KEY_OpenSSL());
    EC_KEY_METHOD_set_sign(made, ec_sign, nullptr, nullptr);
    return made;
  }();
  return method;
}

sys::KeyHandle rsa_key(EVP_PKEY* open, SignerHold signer) {
  const RsaHandle original(EVP_PKEY_get1_RSA(open));
  RsaHandle rsa(original ? RSAPublicKey_dup(original.get()) : nullptr);
  sys::KeyHandle key(EVP_PKEY_new());
  if (!rsa || RSA_set_method(rsa.get(), rsa_method()) != 1 ||
      RSA_set_ex_data(rsa.get(), rsa_index(), new SignerHold(std::move(signer))) != 1 ||
      EVP_PKEY_set1_RSA(key.get(), rsa.get()) != 1) {
    return nullptr;
  }
  return key;
}

sys::KeyHandle ec_key(EVP_PKEY* open, SignerHold signer) {
  const EcHandle original(EVP_PKEY_get1_EC_KEY(open));
  EcHandle ec(original ? EC_KEY_dup(original.get()) : nullptr);
  sys::KeyHandle key(EVP_PKEY_new());
  if (!ec || EC_KEY_set_method(ec.get(), ec_method()) != 1 ||
      EC_KEY_set_ex_data(ec.get(), ec_index(), new SignerHold(std::move(signer))) != 1 ||
      EVP_PKEY_set1_EC_KEY(key.get(), ec.get()) != 1) {
    return nullptr;
  }
  return key;
}

}  // namespace

sys::KeyHandle remote_key(std::shared_ptr<SignerClient> signer) {
  const unsigned char* der = signer->public_key().data();
  const sys::KeyHandle open(
      d2i_PUBKEY(nullptr, &der, static_cast<long>(signer->public_key().size())));
  if (!open) {
    return nullptr;
  }
  switch (EVP_PKEY_get_base_id(open.get())) {
    case EVP_PKEY_RSA: return rsa_key(open.get(), std::move(signer));
    case EVP_PKEY_EC: return ec_key(open.get(), std::move(signer));
    default: return nullptr;
  }
}

}  // namespace mbgate::io
