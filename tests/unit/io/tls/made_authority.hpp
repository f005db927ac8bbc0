// SPDX-License-Identifier: Apache-2.0
// An authority that signs itself, and its empty list of revoked certificates, in PEM.
#pragma once

#include <openssl/pem.h>

#include <string>

#include "sys/openssl.hpp"

namespace mbgate::io {

struct MadeAuthority {
  std::string certificate;
  std::string list;
};

inline std::string written_by(const sys::BioHandle& memory) {
  char* data = nullptr;
  const long size = BIO_get_mem_data(memory.get(), &data);
  return {data, static_cast<std::size_t>(size)};
}

inline sys::CertificateHandle certificate_of(EVP_PKEY* key, const std::string& name,
                                             const char* ends) {
  sys::CertificateHandle made(X509_new());
  X509_set_version(made.get(), X509_VERSION_3);
  ASN1_INTEGER_set(X509_get_serialNumber(made.get()), 1);
  X509_gmtime_adj(X509_getm_notBefore(made.get()), 0);
  X509_gmtime_adj(X509_getm_notAfter(made.get()), 3600);
  if (ends != nullptr) {
    ASN1_TIME_set_string(X509_getm_notAfter(made.get()), ends);
  }
  X509_NAME* const subject = X509_get_subject_name(made.get());
  X509_NAME_add_entry_by_txt(subject, "CN", MBSTRING_ASC,
                             reinterpret_cast<const unsigned char*>(name.c_str()), -1, -1, 0);
  X509_set_issuer_name(made.get(), subject);
  X509_set_pubkey(made.get(), key);
  X509_sign(made.get(), key, EVP_sha256());
  return made;
}

inline sys::CrlHandle list_of(EVP_PKEY* key, const X509* authority) {
  sys::CrlHandle made(X509_CRL_new());
  X509_CRL_set_version(made.get(), X509_CRL_VERSION_2);
  X509_CRL_set_issuer_name(made.get(), X509_get_subject_name(authority));
  X509_CRL_set1_lastUpdate(made.get(), X509_get0_notBefore(authority));
  X509_CRL_set1_nextUpdate(made.get(), X509_get0_notAfter(authority));
  X509_CRL_sign(made.get(), key, EVP_sha256());
  return made;
}

/// `ends`: both, as in a certificate; else in an hour.
inline MadeAuthority make_authority(const std::string& name, const char* ends = nullptr) {
  const sys::KeyHandle key(EVP_PKEY_Q_keygen(nullptr, nullptr, "EC", "P-256"));
  const sys::CertificateHandle certificate = certificate_of(key.get(), name, ends);
  const sys::CrlHandle list = list_of(key.get(), certificate.get());
  const sys::BioHandle certificate_text(BIO_new(BIO_s_mem()));
  const sys::BioHandle list_text(BIO_new(BIO_s_mem()));
  PEM_write_bio_X509(certificate_text.get(), certificate.get());
  PEM_write_bio_X509_CRL(list_text.get(), list.get());
  return {written_by(certificate_text), written_by(list_text)};
}

}  // namespace mbgate::io
