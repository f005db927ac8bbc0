// SPDX-License-Identifier: Apache-2.0
#include "ctl/cert/pem_file.hpp"

#include <fcntl.h>
#include <openssl/pem.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <fstream>
#include <sstream>
#include <system_error>

namespace mbgate::ctl {
namespace {

using openssl::expect;
namespace fs = std::filesystem;

constexpr ::mode_t kSecret = 0600;
constexpr ::mode_t kPublic = 0644;
constexpr ::mode_t kOthers = 0077;

std::string reason(int error) { return std::generic_category().message(error); }

std::string content_of(BIO& memory) {
  char* text = nullptr;
  const long size = BIO_get_mem_data(&memory, &text);
  return {text, static_cast<std::size_t>(size)};
}

openssl::Bio memory() { return openssl::Bio(expect(BIO_new(BIO_s_mem()))); }

/// Writes all of it and has the disk keep it; an errno, or 0.
int write_all(int file, const std::string& text) {
  std::size_t done = 0;
  while (done < text.size()) {
    const ssize_t count = ::write(file, text.data() + done, text.size() - done);
    if (count < 0 && errno != EINTR) {
      return errno;
    }
    done += count < 0 ? 0 : static_cast<std::size_t>(count);
  }
  return ::fsync(file) == 0 ? 0 : errno;
}

/// Into a file that is open and new.
std::string fill(int file, const PemFile& wanted) {
  struct stat status {};
  if (::fchmod(file, wanted.is_secret ? kSecret : kPublic) != 0 || ::fstat(file, &status) != 0) {
    return reason(errno);
  }
  if (wanted.is_secret && (status.st_mode & kOthers) != 0) {
    return "this file system cannot keep a key from other users";
  }
  const int error = write_all(file, wanted.text);
  return error == 0 ? std::string() : reason(error);
}

std::string write_file(const PemFile& wanted, bool replace) {
  const fs::path path = replace ? fs::path(wanted.path.string() + ".new") : wanted.path;
  if (replace) {
    ::unlink(path.c_str());
  }
  const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, kSecret);
  if (file < 0) {
    return path.string() + ": cannot be made: " + reason(errno);
  }
  std::string failure = fill(file, wanted);
  ::close(file);
  if (failure.empty() && replace && ::rename(path.c_str(), wanted.path.c_str()) != 0) {
    failure = reason(errno);
  }
  if (!failure.empty()) {
    ::unlink(path.c_str());
    return path.string() + ": cannot be written: " + failure;
  }
  return {};
}

Result<openssl::Bio, std::string> open_file(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  errno = 0;
  if (!file || fs::is_directory(path) || !(text << file.rdbuf())) {
    const int error = fs::is_directory(path) ? EISDIR : errno;
    return path.string() + ": cannot be read: " + reason(error == 0 ? EIO : error);
  }
  openssl::Bio content = memory();
  const std::string bytes = std::move(text).str();
  expect(BIO_write(content.get(), bytes.data(), static_cast<int>(bytes.size())));
  return content;
}

}  // namespace

std::string to_pem(X509& certificate) {
  const auto bio = memory();
  expect(PEM_write_bio_X509(bio.get(), &certificate));
  return content_of(*bio);
}

std::string to_pem(X509_CRL& list) {
  const auto bio = memory();
  expect(PEM_write_bio_X509_CRL(bio.get(), &list));
  return content_of(*bio);
}

std::string to_pem(EVP_PKEY& key) {
  const auto bio = memory();
  expect(PEM_write_bio_PKCS8PrivateKey(bio.get(), &key, nullptr, nullptr, 0, nullptr, nullptr));
  return content_of(*bio);
}

std::string write_files(const std::vector<PemFile>& files, bool replace) {
  for (const auto& file : files) {
    struct stat status {};
    if (!replace && ::lstat(file.path.c_str(), &status) == 0) {
      return file.path.string() + " is there already: nothing was made; --force replaces it";
    }
  }
  for (const auto& file : files) {
    if (auto failure = write_file(file, replace); !failure.empty()) {
      return failure;
    }
  }
  return {};
}

Result<std::vector<openssl::Certificate>, std::string> read_certificates(const fs::path& path) {
  const auto file = open_file(path);
  if (!file) {
    return file.error();
  }
  std::vector<openssl::Certificate> found;
  while (auto* one = PEM_read_bio_X509(file->get(), nullptr, nullptr, nullptr)) {
    found.emplace_back(one);
  }
  const std::string why = openssl::last_error();  // at the end of the file there is one too
  if (found.empty()) {
    return path.string() + ": is no certificate in PEM: " + why;
  }
  return found;
}

Result<openssl::RevocationList, std::string> read_list(const fs::path& path) {
  const auto file = open_file(path);
  if (!file) {
    return file.error();
  }
  openssl::RevocationList list(PEM_read_bio_X509_CRL(file->get(), nullptr, nullptr, nullptr));
  if (!list) {
    return path.string() + ": is no list of revoked certificates in PEM: " + openssl::last_error();
  }
  return list;
}

Result<Authority, std::string> read_authority(const fs::path& folder) {
  auto certificates = read_certificates(folder / "ca.crt");
  if (!certificates) {
    return certificates.error() + " (mbgatectl cert ca makes an authority)";
  }
  const auto file = open_file(folder / "ca.key");
  if (!file) {
    return file.error();
  }
  openssl::Key key(PEM_read_bio_PrivateKey(file->get(), nullptr, nullptr, nullptr));
  const std::string path = (folder / "ca.key").string();
  if (!key) {
    return path +
           ": is no private key in PEM, or its pass phrase is another: " + openssl::last_error();
  }
  if (X509_check_private_key(certificates->front().get(), key.get()) != 1) {
    static_cast<void>(openssl::last_error());
    return path + " is not the key of " + (folder / "ca.crt").string();
  }
  return Authority{std::move(certificates->front()), std::move(key)};
}

}  // namespace mbgate::ctl
