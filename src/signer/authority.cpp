// SPDX-License-Identifier: Apache-2.0
#include "signer/authority.hpp"

#include <openssl/bio.h>
#include <openssl/err.h>
#include <openssl/pem.h>
#include <openssl/x509v3.h>

#include <algorithm>
#include <array>
#include <iostream>
#include <system_error>

#include "sys/openssl.hpp"

namespace mbgate::signer {
namespace {

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
