// SPDX-License-Identifier: Apache-2.0
#include "io/tls/pem_files.hpp"

#include <openssl/pem.h>

#include <algorithm>
#include <cerrno>
#include <fmt/core.h>
#include <fstream>
#include <system_error>
#include <utility>

namespace mbgate::io {
namespace {

/// A list of a large plant has some thousand entries of 40 bytes.
constexpr std::size_t kLargestPem = 4UL * 1024UL * 1024UL;

struct Pem {
  std::string text;
  std::string why{};  ///< it could not be read; else empty
};

Pem read_pem(const std::string& path) {
  errno = 0;
  std::ifstream file(path, std::ios::binary);
  std::string text(kLargestPem + 1, '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(file.gcount()));
  if (!file.is_open() || file.bad() || (text.empty() && errno != 0)) {
    return {{},
            fmt::format("{}: {}", path, std::generic_category().message(errno != 0 ? errno : EIO))};
  }
  return text.size() > kLargestPem ? Pem{{}, path + ": it is too large"} : Pem{std::move(text)};
}

/// Reads with `next` until there is no more.
template <typename Handle, typename Next>
Result<std::vector<Handle>, std::string> read_all(const std::string& path, const char* what,
                                                  Next next) {
  const Pem pem = read_pem(path);
  if (!pem.why.empty()) {
    return pem.why;
  }
  const sys::BioHandle source(BIO_new_mem_buf(pem.text.data(), static_cast<int>(pem.text.size())));
  std::vector<Handle> found;
  while (Handle one{next(source.get())}) {
    found.push_back(std::move(one));
  }
  const unsigned long error = ERR_peek_last_error();
  ERR_clear_error();
  if (found.empty() || ERR_GET_REASON(error) != PEM_R_NO_START_LINE) {
    return fmt::format("{}: expected {} in PEM (-----BEGIN ...)", path, what);
  }
  return found;
}

std::string subject_text(const X509_NAME& name) {
  const sys::BioHandle text(BIO_new(BIO_s_mem()));
  X509_NAME_print_ex(text.get(), &name, 0, XN_FLAG_RFC2253 & ~ASN1_STRFLGS_ESC_MSB);
  char* data = nullptr;
  const long size = BIO_get_mem_data(text.get(), &data);
  return {data, static_cast<std::size_t>(size)};
}

/// An authority of which there is no list; nullptr: each has one.
const X509_NAME* without_list(const Trusted& trusted) {
  for (const sys::CertificateHandle& authority : trusted.authorities) {
    const X509_NAME* const name = X509_get_subject_name(authority.get());
    const auto is_its = [name](const sys::CrlHandle& list) {
      return X509_NAME_cmp(X509_CRL_get_issuer(list.get()), name) == 0;
    };
    if (std::ranges::none_of(trusted.lists, is_its)) {
      return name;
    }
  }
  return nullptr;
}

}  // namespace

Result<std::vector<sys::CertificateHandle>, std::string> read_certificates(
    const std::string& path) {
  return read_all<sys::CertificateHandle>(path, "certificates", [](BIO* source) {
    return PEM_read_bio_X509(source, nullptr, nullptr, nullptr);
  });
}

Result<std::vector<sys::CrlHandle>, std::string> read_crls(const std::string& path) {
  return read_all<sys::CrlHandle>(path, "lists of revoked certificates", [](BIO* source) {
    return PEM_read_bio_X509_CRL(source, nullptr, nullptr, nullptr);
  });
}

std::optional<std::string> use_certificate(SSL_CTX& context, const std::string& path) {
  const auto chain = read_certificates(path);
  if (!chain) {
    return chain.error();
  }
  if (SSL_CTX_use_certificate(&context, chain->front().get()) != 1) {
    return fmt::format("{}: {}", path, sys::take_openssl_error());
  }
  for (std::size_t at = 1; at < chain->size(); ++at) {
    SSL_CTX_add1_chain_cert(&context, (*chain)[at].get());
  }
  return std::nullopt;
}

Result<Trusted, std::string> use_authorities(SSL_CTX& context, const std::string& authorities,
                                             const std::string& crl) {
  auto certificates = read_certificates(authorities);
  if (!certificates) {
    return certificates.error();
  }
  Trusted trusted{*std::move(certificates)};
  X509_STORE* const store = SSL_CTX_get_cert_store(&context);
  for (const sys::CertificateHandle& authority : trusted.authorities) {
    if (X509_STORE_add_cert(store, authority.get()) != 1) {
      return fmt::format("{}: {}", authorities, sys::take_openssl_error());
    }
  }
  if (crl.empty()) {
    return trusted;
  }
  auto lists = read_crls(crl);
  if (!lists) {
    return lists.error();
  }
  trusted.lists = *std::move(lists);
  if (const X509_NAME* const missing = without_list(trusted)) {
    return fmt::format(
        "{}: expected a list of revoked certificates of each authority in {}, found none of {}",
        crl, authorities, subject_text(*missing));
  }
  for (const sys::CrlHandle& list : trusted.lists) {
    if (X509_STORE_add_crl(store, list.get()) != 1) {
      return fmt::format("{}: {}", crl, sys::take_openssl_error());
    }
  }
  X509_STORE_set_flags(store, X509_V_FLAG_CRL_CHECK | X509_V_FLAG_CRL_CHECK_ALL);
  return trusted;
}

int accept_expired_list(int good, X509_STORE_CTX* store) {
  if (good == 0 && X509_STORE_CTX_get_error(store) == X509_V_ERR_CRL_HAS_EXPIRED) {
    X509_STORE_CTX_set_error(store, X509_V_OK);
    return 1;
  }
  return good;
}

}  // namespace mbgate::io
