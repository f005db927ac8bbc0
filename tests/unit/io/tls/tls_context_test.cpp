// SPDX-License-Identifier: Apache-2.0
// What a context says of files that are not what they should be. That it works is shown against
// other programs (tests/integration/tls_test.py).
#include "io/tls/tls_context.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

namespace mbgate::io {
namespace {

namespace fs = std::filesystem;

class TlsContextTest : public testing::Test {
 protected:
  TlsContextTest() { ::mkdtemp(folder_.data()); }
  ~TlsContextTest() override { fs::remove_all(folder_); }

  std::string write(const char* name, const std::string& text) const {
    const fs::path path = fs::path(folder_) / name;
    std::ofstream(path) << text;
    return path.string();
  }

  /// Why there is none with these.
  static std::string failure(const gateway::TlsSettings& settings) {
    const auto made = TlsContext::make(settings, {});
    return made ? std::string() : made.error().why;
  }

  std::string folder_ = (fs::temp_directory_path() / "mbgate-tls-XXXXXX").string();
};

TEST_F(TlsContextTest, NamesAFileThatIsNotThere) {
  const std::string path = folder_ + "/none.crt";
  EXPECT_EQ(failure({.name = "x", .certificate = path}), path + ": No such file or directory");
}

TEST_F(TlsContextTest, NamesAFileWithoutCertificates) {
  const std::string empty = write("empty.crt", "");
  const std::string text = write("text.crt", "no certificate\n");
  const std::string broken =
      write("broken.crt", "-----BEGIN CERTIFICATE-----\nAAAA\n-----END CERTIFICATE-----\n");
  const std::string expected = ": expected certificates in PEM (-----BEGIN ...)";
  for (const std::string& path : {empty, text, broken}) {
    EXPECT_EQ(failure({.name = "x", .certificate = path}), path + expected);
  }
}

TEST_F(TlsContextTest, CannotReadAFolder) {
  EXPECT_EQ(failure({.name = "x", .certificate = folder_}), folder_ + ": Is a directory");
}

TEST(ResumableSessions, KeepTheNewest) {
  ResumableSessions sessions(2);
  for (const char* id : {"a", "b", "c"}) {
    SessionHandle session(SSL_SESSION_new());
    SSL_SESSION_set1_id(session.get(), reinterpret_cast<const unsigned char*>(id), 1);
    sessions.keep(std::move(session), nullptr);
  }
  EXPECT_EQ(sessions.size(), 2U);
  EXPECT_EQ(sessions.find("a"), nullptr);
  ASSERT_NE(sessions.find("b"), nullptr);
  sessions.forget("b");
  EXPECT_EQ(sessions.find("b"), nullptr);
  EXPECT_NE(sessions.find("c"), nullptr);
}

}  // namespace
}  // namespace mbgate::io
