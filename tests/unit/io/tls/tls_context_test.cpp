// SPDX-License-Identifier: Apache-2.0
// What a context says of files that are not what they should be. That it works is shown against
// other programs (tests/integration/tls_test.py).
#include "io/tls/tls_context.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "unit/io/tls/made_authority.hpp"

namespace mbgate::io {
namespace {

namespace fs = std::filesystem;

class TlsContextTest : public testing::Test {
 public:
  ~TlsContextTest() override { fs::remove_all(folder_); }

 protected:
  TlsContextTest() { ::mkdtemp(folder_.data()); }

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

// OpenSSL would let nobody in whose chain has an authority without a list.
TEST_F(TlsContextTest, WantsAListOfEachAuthority) {
  const MadeAuthority root = make_authority("Root");
  const MadeAuthority plant = make_authority("Plant 7");
  gateway::TlsSettings settings{.name = "x"};
  settings.certificate = write("gateway.crt", plant.certificate);
  settings.authorities = write("ca.crt", root.certificate + plant.certificate);
  const auto missing = [&](const std::string& who) {
    return settings.crl + ": expected a list of revoked certificates of each authority in " +
           settings.authorities + ", found none of CN=" + who;
  };
  settings.crl = write("plant.crl", plant.list);
  EXPECT_EQ(failure(settings), missing("Root"));
  settings.crl = write("root.crl", root.list);
  EXPECT_EQ(failure(settings), missing("Plant 7"));
  settings.crl = write("both.crl", plant.list + root.list);
  EXPECT_EQ(failure(settings), "");
  settings.crl.clear();
  EXPECT_EQ(failure(settings), "");
}

TEST_F(TlsContextTest, KnowsDatesBeyondItsClock) {
  const auto dates = [this](const char* ends) {
    const MadeAuthority made = make_authority("Plant 7", ends);
    gateway::TlsSettings settings{.name = "x"};
    settings.certificate = write("gateway.crt", made.certificate);
    settings.authorities = write("ca.crt", made.certificate);
    settings.crl = write("plant.crl", made.list);
    const auto context = TlsContext::make(settings, {});
    EXPECT_TRUE(context);
    return context ? (*context)->dates() : TlsDates{};
  };
  const auto now = std::chrono::system_clock::now();
  const TlsDates endless = dates("99991231235959Z");
  EXPECT_GT(endless.certificate_ends, now);
  EXPECT_GT(endless.crl_ends, now);
  EXPECT_LT(dates("15001231235959Z").certificate_ends, now);
}

}  // namespace
}  // namespace mbgate::io
