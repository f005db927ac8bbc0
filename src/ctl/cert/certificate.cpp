// SPDX-License-Identifier: Apache-2.0
#include "ctl/cert/certificate.hpp"

#include <arpa/inet.h>
#include <openssl/ec.h>
#include <openssl/rsa.h>
#include <openssl/x509v3.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <ctime>

#include "ctl/cert/role_extension.hpp"
#include "ctl/visible_text.hpp"

namespace mbgate::ctl {
namespace {

using openssl::expect;

constexpr int kSerialBits = 127;  // positive, and never the same twice
constexpr long kClockBehind = 3600;
constexpr long kVersion3 = 2;

void add_extension(X509& certificate, X509V3_CTX& context, int kind, const std::string& value) {
  const std::unique_ptr<X509_EXTENSION, openssl::Free<X509_EXTENSION_free>> extension(
      expect(X509V3_EXT_nconf_nid(nullptr, &context, kind, value.c_str())));
  expect(X509_add_ext(&certificate, extension.get(), -1));
}

std::string alternative_names(const std::vector<std::string>& addresses) {
  std::string text;
  for (const auto& address : addresses) {
    text.append(text.empty() ? "" : ",").append(is_numeric_address(address) ? "IP:" : "DNS:");
    text.append(address);
  }
  return text;
}

void add_extensions(X509& certificate, const CertificateContent& content, X509& issuer) {
  X509V3_CTX context;
  X509V3_set_ctx_nodb(&context);
  X509V3_set_ctx(&context, &issuer, &certificate, nullptr, nullptr, 0);
  const bool is_authority = content.purpose == Purpose::authority;
  add_extension(certificate, context, NID_basic_constraints,
                is_authority ? "critical,CA:TRUE,pathlen:0" : "critical,CA:FALSE");
  add_extension(certificate, context, NID_key_usage,
                is_authority ? "critical,keyCertSign,cRLSign" : "critical,digitalSignature");
  add_extension(certificate, context, NID_subject_key_identifier, "hash");
  if (!is_authority) {
    add_extension(certificate, context, NID_authority_key_identifier, "keyid:always");
    add_extension(certificate, context, NID_ext_key_usage,
                  content.purpose == Purpose::server ? "serverAuth" : "clientAuth");
  }
  if (!content.addresses.empty()) {
    add_extension(certificate, context, NID_subject_alt_name, alternative_names(content.addresses));
  }
  if (content.role) {
    add_role(certificate, *content.role);
  }
}

void set_serial(X509& certificate) {
  const std::unique_ptr<BIGNUM, openssl::Free<BN_free>> number(expect(BN_new()));
  expect(BN_rand(number.get(), kSerialBits, BN_RAND_TOP_ONE, BN_RAND_BOTTOM_ANY));
  expect(BN_to_ASN1_INTEGER(number.get(), X509_get_serialNumber(&certificate)));
}

}  // namespace

openssl::Key make_key(std::optional<unsigned> rsa_bits) {
  return openssl::Key(expect(rsa_bits ? EVP_RSA_gen(*rsa_bits) : EVP_EC_gen("P-256")));
}

openssl::Certificate make_certificate(const CertificateContent& content, EVP_PKEY& key,
                                      const Authority* authority) {
  openssl::Certificate certificate(expect(X509_new()));
  X509& made = *certificate;
  expect(X509_set_version(&made, kVersion3));
  set_serial(made);
  expect(X509_gmtime_adj(X509_getm_notBefore(&made), -kClockBehind));
  expect(X509_time_adj_ex(X509_getm_notAfter(&made), static_cast<int>(content.days), 0, nullptr));
  X509_NAME* const name = X509_get_subject_name(&made);
  // NOLINTNEXTLINE(cppcoreguidelines-pro-type-reinterpret-cast): OpenSSL has bytes without a sign
  const auto* const text = reinterpret_cast<const unsigned char*>(content.name.c_str());
  expect(X509_NAME_add_entry_by_txt(name, "CN", MBSTRING_UTF8, text, -1, -1, 0));
  X509& issuer = authority == nullptr ? made : *authority->certificate;
  expect(X509_set_issuer_name(&made, X509_get_subject_name(&issuer)));
  expect(X509_set_pubkey(&made, &key));
  add_extensions(made, content, issuer);
  expect(X509_sign(&made, authority == nullptr ? &key : authority->key.get(), EVP_sha256()));
  return certificate;
}

bool is_numeric_address(const std::string& text) {
  std::array<unsigned char, sizeof(in6_addr)> address{};
  return inet_pton(AF_INET, text.c_str(), address.data()) == 1 ||
         inet_pton(AF_INET6, text.c_str(), address.data()) == 1;
}

bool is_host_name(const std::string& text) {
  constexpr std::size_t kLongest = 253;
  const auto is_allowed = [](unsigned char it) {
    return std::isalnum(it) != 0 || it == '-' || it == '.';
  };
  const auto is_last = [](unsigned char it) { return std::isalnum(it) != 0; };
  return !text.empty() && text.size() <= kLongest && std::ranges::all_of(text, is_allowed) &&
         is_last(static_cast<unsigned char>(text.front())) &&
         is_last(static_cast<unsigned char>(text.back())) && text.find("..") == std::string::npos &&
         !std::ranges::all_of(text, [](unsigned char it) {
           return std::isdigit(it) != 0 || it == '.';  // an address, and no good one
         });
}

Seconds time_of(const ASN1_TIME& time) {
  std::tm parts{};
  expect(ASN1_TIME_to_tm(&time, &parts));
  return std::chrono::time_point_cast<std::chrono::seconds>(
      std::chrono::system_clock::from_time_t(timegm(&parts)));
}

std::string time_text(Seconds time) {
  const std::time_t seconds = std::chrono::system_clock::to_time_t(time);
  std::tm parts{};
  gmtime_r(&seconds, &parts);
  std::array<char, 64> text{};
  return {text.data(), std::strftime(text.data(), text.size(), "%Y-%m-%d %H:%M:%S UTC", &parts)};
}

std::string name_text(const X509_NAME& name) {
  const openssl::Bio memory(expect(BIO_new(BIO_s_mem())));
  X509_NAME_print_ex(memory.get(), &name, 0, XN_FLAG_RFC2253 & ~ASN1_STRFLGS_ESC_MSB);
  char* text = nullptr;
  const long size = BIO_get_mem_data(memory.get(), &text);
  return visible_text({text, static_cast<std::size_t>(size)});
}

}  // namespace mbgate::ctl
