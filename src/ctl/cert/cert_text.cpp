// SPDX-License-Identifier: Apache-2.0
#include "ctl/cert/cert_text.hpp"

#include <openssl/x509v3.h>

#include <array>
#include <cstdint>
#include <cstdio>
#include <utility>

#include "ctl/cert/pem_file.hpp"
#include "ctl/cert/role_extension.hpp"

namespace mbgate::ctl {
namespace {

using openssl::expect;

std::string hex(const unsigned char* bytes, std::size_t count) {
  std::string text;
  std::array<char, 3> digits{};
  for (std::size_t at = 0; at < count; ++at) {
    std::snprintf(digits.data(), digits.size(), "%02x", bytes[at]);
    text += digits.data();
  }
  return text;
}

std::string serial_text(const ASN1_INTEGER& serial) {
  return hex(ASN1_STRING_get0_data(&serial), static_cast<std::size_t>(ASN1_STRING_length(&serial)));
}

/// In quotes. What is no character of a line is shown by its number.
std::string role_in_quotes(const std::string& text) {
  std::string result = "\"";
  for (const char it : text) {
    const auto byte = static_cast<unsigned char>(it);
    if (byte < 0x20 || byte == 0x7F) {
      result += "\\x" + hex(&byte, 1);
    } else {
      result += it == '"' || it == '\\' ? std::string{'\\', it} : std::string{it};
    }
  }
  return result + "\"";
}

std::string role_text(const X509& certificate) {
  const auto read = read_role(certificate);
  if (read.kind == routing::ClientRole::Kind::unreadable) {
    return "unreadable: a gateway answers every request with exception 01";
  }
  return read.name.empty() ? "none: the NULL role, which rules write as \"\""
                           : role_in_quotes(read.name);
}

std::string days_text(Seconds from, Seconds until) {
  const auto days = std::chrono::duration_cast<std::chrono::days>(until - from).count();
  return std::to_string(days) + (days == 1 ? " day" : " days");
}

std::string validity_text(Seconds begin, Seconds end, Seconds now) {
  std::string text = time_text(begin) + " to " + time_text(end);
  if (now < begin) {
    return text + ": NOT YET VALID";
  }
  return text + (now > end ? ": EXPIRED " + days_text(end, now) + " ago"
                           : " (" + days_text(now, end) + " left)");
}

std::string key_text(const X509& certificate) {
  EVP_PKEY* const key = X509_get0_pubkey(&certificate);
  if (key == nullptr) {
    static_cast<void>(openssl::last_error());
    return "of a kind that is not known here";
  }
  const char* const kind = EVP_PKEY_get0_type_name(key);
  return std::string(kind == nullptr ? "unknown" : kind) + ", " +
         std::to_string(EVP_PKEY_get_bits(key)) + " bits";
}

/// The alternative names as OpenSSL prints them: "DNS:plant, IP Address:192.0.2.1".
std::string names_text(const X509& certificate) {
  const int place = X509_get_ext_by_NID(&certificate, NID_subject_alt_name, -1);
  if (place < 0) {
    return {};
  }
  const openssl::Bio memory(expect(BIO_new(BIO_s_mem())));
  X509V3_EXT_print(memory.get(), X509_get_ext(&certificate, place), 0, 0);
  char* text = nullptr;
  const long size = BIO_get_mem_data(memory.get(), &text);
  return {text, static_cast<std::size_t>(size)};
}

std::string purpose_text(X509& certificate) {
  if (X509_check_ca(&certificate) != 0) {
    return "authority";
  }
  const auto usage = X509_get_extended_key_usage(&certificate);
  if (usage == UINT32_MAX) {
    return "anything";
  }
  std::string text = (usage & XKU_SSL_SERVER) != 0 ? "server" : "";
  if ((usage & XKU_SSL_CLIENT) != 0) {
    text += text.empty() ? "client" : ", client";
  }
  return text.empty() ? "neither server nor client" : text;
}

std::string fingerprint_text(const X509& certificate) {
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  unsigned size = 0;
  expect(X509_digest(&certificate, EVP_sha256(), digest.data(), &size));
  return hex(digest.data(), size);
}

std::string line(const std::string& what, const std::string& text) {
  constexpr std::size_t kColumn = 11;
  return "  " + what + std::string(kColumn - what.size(), ' ') + text + "\n";
}

std::string in(const std::filesystem::path& folder, const std::string& file) {
  return (folder == "." ? std::filesystem::path(file) : folder / file).string();
}

}  // namespace

std::string describe(const X509& certificate, Seconds now) {
  // OpenSSL keeps what it has read of the extensions in the certificate itself.
  const openssl::Certificate copy(expect(X509_dup(&certificate)));
  std::string text = line("subject", name_text(*X509_get_subject_name(&certificate)));
  const auto purpose = purpose_text(*copy);
  text += line("for", purpose);
  if (purpose.find("authority") == std::string::npos) {
    text += line("role", role_text(certificate));
  }
  if (const auto names = names_text(certificate); !names.empty()) {
    text += line("names", names);
  }
  text += line("issuer", name_text(*X509_get_issuer_name(&certificate)));
  text += line("valid", validity_text(time_of(*X509_get0_notBefore(&certificate)),
                                      time_of(*X509_get0_notAfter(&certificate)), now));
  text += line("key", key_text(certificate));
  text += line("serial", serial_text(*X509_get0_serialNumber(&certificate)));
  return text + line("SHA-256", fingerprint_text(certificate));
}

std::string describe(X509_CRL& list, Seconds now) {
  std::string text = line("issuer", name_text(*X509_CRL_get_issuer(&list)));
  const auto made = time_of(*X509_CRL_get0_lastUpdate(&list));
  const auto* const next = X509_CRL_get0_nextUpdate(&list);
  text += line("valid", next == nullptr ? time_text(made) + ", without an end"
                                        : validity_text(made, time_of(*next), now));
  const auto* const entries = X509_CRL_get_REVOKED(&list);
  if (sk_X509_REVOKED_num(entries) <= 0) {
    return text + line("revoked", "none");
  }
  for (int at = 0; at < sk_X509_REVOKED_num(entries); ++at) {
    const X509_REVOKED* const entry = sk_X509_REVOKED_value(entries, at);
    text += line("revoked", serial_text(*X509_REVOKED_get0_serialNumber(entry)) + " at " +
                                time_text(time_of(*X509_REVOKED_get0_revocationDate(entry))));
  }
  return text;
}

std::string role_in_file(const std::filesystem::path& file) {
  const auto certificates = read_certificates(file);
  return certificates ? role_text(*certificates->front()) : std::string();
}

std::string advice_after(const MakeAuthority& made) {
  const auto& folder = made.make.folder;
  const auto key = in(folder, "ca.key");
  const auto certificate = in(folder, "ca.crt");
  const auto list = in(folder, "ca.crl");
  return "Made:\n  " + key +
         "  the authority's private key. Whoever has it can make certificates with any\n"
         "    role: keep it off the gateway, on a machine or a medium that is locked away, and a\n"
         "    copy in another such place.\n  " +
         certificate +
         "  the authority's certificate, no secret: to the gateway, into\n"
         "    /etc/mbgate/certs, and to the machine of each client.\n  " +
         list +
         "  the list of revoked certificates, empty: to the gateway, into\n"
         "    /etc/mbgate/certs. It must be renewed within " +
         std::to_string(kListDays) +
         " days (mbgatectl cert crl).\n"
         "On the gateway, as root:\n"
         "  install -m 0644 ca.crt ca.crl /etc/mbgate/certs/\n"
         "Next: mbgatectl cert server NAME --address ADDRESS, and\n"
         "mbgatectl cert client NAME --role ROLE for each client.\n";
}

std::string advice_after(const MakeServer& made) {
  const auto& name = made.make.name;
  return "Made:\n  " + in(made.make.folder, name + ".key") +
         "  the gateway's private key: to the gateway only, then delete it here.\n  " +
         in(made.make.folder, name + ".crt") +
         "  the gateway's certificate, no secret.\n"
         "On the gateway, as root:\n"
         "  install -o root -g mbgate-tls -m 0640 " +
         name +
         ".key /etc/mbgate/tls/\n"
         "  install -m 0644 " +
         name +
         ".crt ca.crt ca.crl /etc/mbgate/certs/\n"
         "In /etc/mbgate/mbgate.toml:\n"
         "  [[tls]]\n  name = \"plant\"\n  certificate = \"certs/" +
         name + ".crt\"\n  key = \"" + name +
         ".key\"\n  authorities = \"certs/ca.crt\"\n  crl = \"certs/ca.crl\"\n"
         "and `tls = \"plant\"` in its [[listen]]. Each role needs a [[rule]] that permits "
         "something.\n";
}

std::string advice_after(const MakeClient& made) {
  const auto& name = made.make.name;
  return "Made:\n  " + in(made.make.folder, name + ".key") +
         "  the client's private key: to the client's machine only, readable by its\n"
         "    program alone, then delete it here. Whoever has it acts as this client.\n  " +
         in(made.make.folder, name + ".crt") +
         "  the client's certificate, no secret: to the client's machine,\n"
         "    with ca.crt. " +
         (made.role ? "Its role is " + role_in_quotes(*made.role) : "It has the NULL role, \"\"") +
         ": the gateway permits what a [[rule]] with this role says.\n"
         "There:\n"
         "  mbgatectl read holding 0 --host GATEWAY --tls --certificate " +
         name + ".crt --key " + name + ".key --authorities ca.crt\n";
}

std::string advice_after_list(const std::filesystem::path& folder) {
  return "On the gateway, as root, with the new " + in(folder, "ca.crl") +
         ":\n"
         "  install -m 0644 ca.crl /etc/mbgate/certs/ && systemctl reload mbgated\n"
         "The gateway then closes the connections of clients that are revoked.\n";
}

}  // namespace mbgate::ctl
