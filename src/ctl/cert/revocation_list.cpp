// SPDX-License-Identifier: Apache-2.0
#include "ctl/cert/revocation_list.hpp"

#include <openssl/x509v3.h>

#include <cstdint>
#include <tuple>

namespace mbgate::ctl {
namespace {

using openssl::expect;
using Integer = std::unique_ptr<ASN1_INTEGER, openssl::Free<ASN1_INTEGER_free>>;
using Time = std::unique_ptr<ASN1_TIME, openssl::Free<ASN1_TIME_free>>;

constexpr long kListVersion2 = 1;

std::int64_t number_of(const X509_CRL& list) {
  const Integer number(
      static_cast<ASN1_INTEGER*>(X509_CRL_get_ext_d2i(&list, NID_crl_number, nullptr, nullptr)));
  std::int64_t value = 0;
  if (number) {
    expect(ASN1_INTEGER_get_int64(&value, number.get()));
  }
  return value;
}

void add_list_extensions(X509_CRL& list, X509& issuer, std::int64_t number) {
  const Integer value(expect(ASN1_INTEGER_new()));
  expect(ASN1_INTEGER_set_int64(value.get(), number));
  expect(X509_CRL_add1_ext_i2d(&list, NID_crl_number, value.get(), 0, 0));
  X509V3_CTX context;
  X509V3_set_ctx_nodb(&context);
  X509V3_set_ctx(&context, &issuer, nullptr, nullptr, &list, 0);
  const std::unique_ptr<X509_EXTENSION, openssl::Free<X509_EXTENSION_free>> extension(expect(
      X509V3_EXT_nconf_nid(nullptr, &context, NID_authority_key_identifier, "keyid:always")));
  expect(X509_CRL_add_ext(&list, extension.get(), -1));
}

}  // namespace

openssl::RevocationList next_list(const Authority& authority, X509_CRL* old, unsigned days) {
  openssl::RevocationList list(expect(X509_CRL_new()));
  expect(X509_CRL_set_version(list.get(), kListVersion2));
  expect(X509_CRL_set_issuer_name(list.get(), X509_get_subject_name(authority.certificate.get())));
  const Time now(expect(X509_gmtime_adj(nullptr, 0)));
  expect(X509_CRL_set1_lastUpdate(list.get(), now.get()));
  const Time next(expect(X509_time_adj_ex(nullptr, static_cast<int>(days), 0, nullptr)));
  expect(X509_CRL_set1_nextUpdate(list.get(), next.get()));
  add_list_extensions(*list, *authority.certificate, old == nullptr ? 1 : number_of(*old) + 1);
  const auto* const entries = old == nullptr ? nullptr : X509_CRL_get_REVOKED(old);
  for (int at = 0; at < sk_X509_REVOKED_num(entries); ++at) {
    expect(X509_CRL_add0_revoked(list.get(),
                                 expect(X509_REVOKED_dup(sk_X509_REVOKED_value(entries, at)))));
  }
  expect(X509_CRL_sort(list.get()));
  expect(X509_CRL_sign(list.get(), authority.key.get(), EVP_sha256()));
  return list;
}

bool is_list_of(X509_CRL& list, const Authority& authority) {
  const bool is_signed = X509_CRL_verify(&list, authority.key.get()) == 1;
  static_cast<void>(openssl::last_error());
  return is_signed;
}

std::optional<Seconds> revoked_at(X509_CRL& list, X509& certificate) {
  X509_REVOKED* found = nullptr;
  if (X509_CRL_get0_by_cert(&list, &found, &certificate) != 1) {
    return std::nullopt;
  }
  return time_of(*X509_REVOKED_get0_revocationDate(found));
}

void revoke(X509_CRL& list, X509& certificate, const Authority& authority) {
  std::unique_ptr<X509_REVOKED, openssl::Free<X509_REVOKED_free>> entry(expect(X509_REVOKED_new()));
  expect(X509_REVOKED_set_serialNumber(entry.get(), X509_get_serialNumber(&certificate)));
  const Time now(expect(X509_gmtime_adj(nullptr, 0)));
  expect(X509_REVOKED_set_revocationDate(entry.get(), now.get()));
  expect(X509_CRL_add0_revoked(&list, entry.get()));
  std::ignore = entry.release();  // the list's now
  expect(X509_CRL_sort(&list));
  expect(X509_CRL_sign(&list, authority.key.get(), EVP_sha256()));
}

std::size_t revoked_count(X509_CRL& list) {
  const auto* const entries = X509_CRL_get_REVOKED(&list);
  return entries == nullptr ? 0 : static_cast<std::size_t>(sk_X509_REVOKED_num(entries));
}

}  // namespace mbgate::ctl
