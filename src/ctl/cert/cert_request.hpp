// SPDX-License-Identifier: Apache-2.0
// What `mbgatectl cert` is asked to do, as plain values.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace mbgate::ctl {

inline constexpr unsigned kAuthorityDays = 3650;
/// Two and a quarter years: what is renewed yearly has time to be late.
inline constexpr unsigned kCertificateDays = 825;
inline constexpr unsigned kListDays = 365;

/// What every new certificate has.
struct NewCertificate {
  std::filesystem::path folder = ".";  ///< of the authority's files and the new ones
  std::string name;                    ///< its common name; of all but the authority, its files too
  unsigned days = kCertificateDays;
  std::optional<unsigned> rsa_bits;  ///< none: an ECDSA key on P-256
  bool replace = false;              ///< files that are there already
};

/// Makes ca.key, ca.crt and an empty ca.crl.
struct MakeAuthority {
  NewCertificate make;
};

/// Makes NAME.key and NAME.crt for a gateway. The authority's certificate stands behind its own.
struct MakeServer {
  NewCertificate make;
  std::vector<std::string> addresses;  ///< IP addresses and host names by which clients reach it
};

/// Makes NAME.key and NAME.crt for a client.
struct MakeClient {
  NewCertificate make;
  std::optional<std::string> role;  ///< none: the NULL role
};

/// Adds a certificate to ca.crl.
struct Revoke {
  std::filesystem::path folder = ".";
  std::filesystem::path file;
  unsigned days = kListDays;  ///< until the list is to be renewed
};

/// Signs ca.crl anew.
struct RenewList {
  std::filesystem::path folder = ".";
  unsigned days = kListDays;
  bool replace = false;  ///< by an empty one, whatever is there
};

/// Says what is in a file of certificates or in a list of revoked ones.
struct ShowCertificate {
  std::filesystem::path file;
};

using CertCommand =
    std::variant<MakeAuthority, MakeServer, MakeClient, Revoke, RenewList, ShowCertificate>;

}  // namespace mbgate::ctl
