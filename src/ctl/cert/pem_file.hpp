// SPDX-License-Identifier: Apache-2.0
// The files of an authority and of what it has signed, in PEM.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "ctl/cert/certificate.hpp"
#include "modbus/result.hpp"

namespace mbgate::ctl {

std::string to_pem(X509& certificate);
std::string to_pem(X509_CRL& list);
std::string to_pem(EVP_PKEY& key);

/// A file that is to be written.
struct PemFile {
  std::filesystem::path path;
  std::string text;
  bool is_secret = false;  ///< for its owner alone, from the first byte on
};

/// Why a file cannot be written, or nothing. A file that is there is an error, or is replaced as a
/// whole.
std::string write_files(const std::vector<PemFile>& files, bool replace);

/// All certificates of a file, at least one. The errors of these are full sentences.
Result<std::vector<openssl::Certificate>, std::string> read_certificates(
    const std::filesystem::path& path);
Result<openssl::RevocationList, std::string> read_list(const std::filesystem::path& path);
/// ca.crt and ca.key of a folder. OpenSSL asks for the pass phrase of a key that has one.
Result<Authority, std::string> read_authority(const std::filesystem::path& folder);

}  // namespace mbgate::ctl
