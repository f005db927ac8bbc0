// SPDX-License-Identifier: Apache-2.0
// Keys, and certificates signed by an authority.
#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include "ctl/tls/openssl.hpp"

namespace mbgate::ctl {

using Seconds = std::chrono::sys_seconds;

/// An authority, with what signs in its name.
struct Authority {
  openssl::Certificate certificate;
  openssl::Key key;
};

/// What a certificate is for.
enum class Purpose { authority, server, client };

/// What is put into a certificate.
struct CertificateContent {
  Purpose purpose = Purpose::client;
  std::string name;  ///< the common name
  unsigned days = 1;
  std::vector<std::string> addresses{};  ///< of a server: IP addresses and host names
  std::optional<std::string> role{};     ///< of a client; must not be wrong
};

/// On P-256, or RSA of so many bits.
openssl::Key make_key(std::optional<unsigned> rsa_bits);

/// Signed by `authority`, or by its own key if there is none. Valid from an hour before now, for
/// clocks that are behind.
openssl::Certificate make_certificate(const CertificateContent& content, EVP_PKEY& key,
                                      const Authority* authority);

/// Is it an IPv4 or IPv6 address?
bool is_numeric_address(const std::string& text);

/// Is it letters, digits and hyphens between dots?
bool is_host_name(const std::string& text);

/// The time in a certificate or a list.
Seconds time_of(const ASN1_TIME& time);

/// "2026-11-25 15:00:00 UTC".
std::string time_text(Seconds time);

/// "CN=plant", as RFC 2253 has it.
std::string name_text(const X509_NAME& name);

}  // namespace mbgate::ctl
