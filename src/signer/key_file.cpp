// SPDX-License-Identifier: Apache-2.0
#include "signer/key_file.hpp"

#include <fcntl.h>
#include <fnmatch.h>
#include <openssl/bio.h>
#include <openssl/crypto.h>
#include <openssl/err.h>
#include <openssl/pem.h>
#include <openssl/rsa.h>
#include <openssl/x509.h>
#include <openssl/x509v3.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <iostream>
#include <system_error>

#include "sys/openssl.hpp"
#include "sys/unique_fd.hpp"

namespace mbgate::signer {
namespace {

/// RSA with 16384 bits takes 13 KiB.
constexpr std::size_t kLargestFile = 16'384;

/// Why no file of this name may be used; empty: it may.
std::string objection(const KeyStore& store, const std::string& name) {
  if (name.empty() || name.front() == '.' || name.find_first_of({"/\0", 2}) != std::string::npos) {
    return "a key is named by its file in the folder, without '/'";
  }
  std::string known;
  for (const std::string& pattern : store.names) {
    if (::fnmatch(pattern.c_str(), name.c_str(), 0) == 0) {
      return {};
    }
    known += (known.empty() ? "" : ", ") + pattern;
  }
  return name + ": mbgate-signer may use " + known + ": give --key " + name +
         " in its unit (systemctl edit mbgate-signer)";
}

/// Why the file must not be used as it is; empty: it may.
std::string objection(const struct stat& file) {
  if (!S_ISREG(file.st_mode)) {
    return "it is not a regular file";
  }
  if ((file.st_mode & (S_IWGRP | S_IWOTH)) != 0) {
    return "users other than its owner may write to it: chmod go-w";
  }
  if ((file.st_mode & S_IROTH) != 0) {
    return "everybody may read it: chmod o-r";
  }
  return static_cast<std::size_t>(file.st_size) > kLargestFile ? "it is too large for a key" : "";
}

/// Asks for no password: a process without a terminal would wait for ever.
int no_password(char* /*buffer*/, int /*size*/, int /*writing*/, void* /*data*/) { return -1; }

std::optional<Octets> finish(EVP_PKEY_CTX* context, std::span<const std::uint8_t> bytes) {
  std::size_t size = 0;
  if (EVP_PKEY_sign(context, nullptr, &size, bytes.data(), bytes.size()) <= 0) {
    return std::nullopt;
  }
  Octets signature(size);
  if (EVP_PKEY_sign(context, signature.data(), &size, bytes.data(), bytes.size()) <= 0) {
    return std::nullopt;
  }
  signature.resize(size);
  return signature;
}

namespace fs = std::filesystem;

constexpr std::array<std::string_view, 3> kEndings{".crt", ".pem", ".cer"};

bool may_have_certificates(const fs::path& file, std::string_view key_file) {
  const std::string ending = file.extension().string();
  return file.filename() == key_file || std::ranges::find(kEndings, ending) != kEndings.end();
}

/// One behind the other: a file may have a chain, and other things between its certificates.
bool has_authority_of(const fs::path& file, const EVP_PKEY* key) {
  const sys::BioHandle text(BIO_new_file(file.c_str(), "r"));
  if (!text) {
    std::cerr << file.string() << ": cannot be read, so it is not known whether an authority's "
              << "certificate is there\n";
  }
  bool found = false;
  while (text && !found && BIO_eof(text.get()) == 0) {
    const sys::CertificateHandle certificate(
        PEM_read_bio_X509(text.get(), nullptr, nullptr, nullptr));
    found = certificate && X509_check_ca(certificate.get()) != 0 &&
            EVP_PKEY_eq(X509_get0_pubkey(certificate.get()), key) == 1;
  }
  ERR_clear_error();
  return found;
}

}  // namespace

std::optional<KeyFile> KeyFile::read(std::string_view pem, const std::string& name) {
  const sys::BioHandle source(BIO_new_mem_buf(pem.data(), static_cast<int>(pem.size())));
  sys::KeyHandle key(PEM_read_bio_PrivateKey(source.get(), nullptr, no_password, nullptr));
  ERR_clear_error();
  if (!key) {
    return std::nullopt;
  }
  const int kind = EVP_PKEY_get_base_id(key.get());
  KeyFile file(std::move(key), name);
  return kind == EVP_PKEY_RSA || kind == EVP_PKEY_EC ? std::optional(std::move(file))
                                                     : std::nullopt;
}

KeyFile::Opened KeyFile::open(const KeyStore& store, const std::string& name) {
  if (std::string why = signer::objection(store, name); !why.empty()) {
    return {std::nullopt, std::move(why)};
  }
  // Not to wait where somebody has put a named pipe.
  const sys::UniqueFd file(
      ::open((store.folder + "/" + name).c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK));
  struct stat facts {};
  if (!file.is_open() || ::fstat(file.get(), &facts) != 0) {
    return {std::nullopt, errno == ELOOP ? name + ": it is a link"
                                         : name + ": " + std::generic_category().message(errno)};
  }
  if (const std::string why = signer::objection(facts); !why.empty()) {
    return {std::nullopt, name + ": " + why};
  }
  std::array<char, kLargestFile> pem{};
  const ssize_t size = ::read(file.get(), pem.data(), pem.size());
  auto key = size > 0 ? read({pem.data(), static_cast<std::size_t>(size)}, name) : std::nullopt;
  OPENSSL_cleanse(pem.data(), pem.size());
  if (!key) {
    return {std::nullopt, name + ": expected a private key of RSA or EC in PEM, without password"};
  }
  for (const std::string& folder : {store.folder, store.certificates}) {
    const auto certificate = authority_certificate(folder, name, key->key_.get());
    if (!certificate.empty()) {
      return {std::nullopt, name + ": is the key of an authority, whose certificate is " +
                                certificate.string() + ": it does not belong on a gateway"};
    }
  }
  return {std::move(key), {}};
}

Octets KeyFile::public_key() const {
  std::uint8_t* der = nullptr;
  const int size = i2d_PUBKEY(key_.get(), &der);
  Octets bytes;
  if (size > 0) {
    bytes.assign(der, der + size);
  }
  OPENSSL_free(der);
  return bytes;
}

std::string_view KeyFile::objection(signing::Question how,
                                    std::span<const std::uint8_t> bytes) const {
  if (is_rsa() == (how == signing::Question::ecdsa)) {
    return is_rsa() ? "the key is one of RSA" : "the key is one of EC";
  }
  return objection_to_signing(how, bytes, EVP_PKEY_get_bits(key_.get()));
}

std::optional<Octets> KeyFile::sign(signing::Question how,
                                    std::span<const std::uint8_t> bytes) const {
  const sys::KeyUseHandle context(EVP_PKEY_CTX_new(key_.get(), nullptr));
  const bool begun = context && EVP_PKEY_sign_init(context.get()) > 0;
  const int padding = how == signing::Question::rsa_pkcs1 ? RSA_PKCS1_PADDING : RSA_NO_PADDING;
  const bool ready =
      begun && (!is_rsa() || EVP_PKEY_CTX_set_rsa_padding(context.get(), padding) > 0);
  auto signature = ready ? finish(context.get(), bytes) : std::nullopt;
  ERR_clear_error();
  return signature;
}

fs::path authority_certificate(const fs::path& folder, std::string_view key_file, EVP_PKEY* key) {
  std::error_code error;
  for (auto entry = fs::directory_iterator(folder, error); entry != fs::directory_iterator();
       entry.increment(error)) {
    if (may_have_certificates(entry->path(), key_file) && entry->is_regular_file(error) &&
        has_authority_of(entry->path(), key)) {
      return entry->path();
    }
  }
  if (error && error != std::errc::no_such_file_or_directory) {
    std::cerr << folder.string() << ": " << error.message() << '\n';
  }
  return {};
}

}  // namespace mbgate::signer
