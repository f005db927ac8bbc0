// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "report/text.hpp"
#include "support/hex.hpp"

namespace mbgate::report {
namespace {

using routing::ClientRole;

std::string text_of(std::string_view pdu) { return request_text({{}, 7, test::unhex(pdu)}); }

TEST(AskedText, HasRegistersAndValues) {
  EXPECT_EQ(text_of("06 007C 00E1"), "function 6 at unit 7, holding register 124 = 225");
  EXPECT_EQ(text_of("05 0003 FF00"), "function 5 at unit 7, coil 3 = 1");
  EXPECT_EQ(text_of("05 0003 0000"), "function 5 at unit 7, coil 3 = 0");
  EXPECT_EQ(text_of("0F 0008 000A 02 05 02"),
            "function 15 at unit 7, coils 8..17 = 1 0 1 0 0 0 0 0 and 2 more");
  EXPECT_EQ(text_of("10 0064 0002 04 0001 FFFF"),
            "function 16 at unit 7, holding registers 100..101 = 1 65535");
  EXPECT_EQ(text_of("16 0004 00F2 0025"),
            "function 22 at unit 7, holding register 4 and 242 or 37");
  EXPECT_EQ(
      text_of("17 0003 0006 000E 0001 02 00FF"),
      "function 23 at unit 7, reads holding registers 3..8, writes holding register 14 = 255");
  EXPECT_EQ(text_of("03 001E 0002"), "function 3 at unit 7, reads holding registers 30..31");
}

TEST(AskedText, HasWhatIsThereOfOtherRequests) {
  EXPECT_EQ(text_of("08 000A 0000"), "function 8 at unit 7, sub-function 10");
  EXPECT_EQ(text_of("07"), "function 7 at unit 7");
  EXPECT_EQ(text_of("46 01 02"), "function 70 at unit 7, data 01 02");
  EXPECT_EQ(text_of("46 01 02 03 04 05 06 07 08 09"),
            "function 70 at unit 7, data 01 02 03 04 05 06 07 08 ...");
  EXPECT_EQ(text_of("06 00"), "function 6 at unit 7, data 00");
}

TEST(AskedText, SaysWhoByTheCertificate) {
  const auto text = [](ClientRole role) { return identity_text({{}, {}, std::move(role)}); };
  EXPECT_EQ(text({}), "");
  EXPECT_EQ(text({ClientRole::Kind::named, "operator"}), " (role \"operator\")");
  EXPECT_EQ(text({ClientRole::Kind::named, "operator", "panel 3"}),
            " (role \"operator\", certificate \"panel 3\")");
  EXPECT_EQ(text({ClientRole::Kind::named, ""}), " (no role)");
  EXPECT_EQ(text({ClientRole::Kind::unreadable}), " (its role cannot be read)");
}

TEST(AskedText, LetsNoNameWriteOverTheTerminal) {
  const auto text = [](std::string certificate) {
    return identity_text({{}, {}, {ClientRole::Kind::named, "r", std::move(certificate)}});
  };
  EXPECT_EQ(text("a\x1B[2J\nb\"\x7F"), " (role \"r\", certificate \"a?[2J?b??\")");
  EXPECT_EQ(text("\xC2\x9B"), " (role \"r\", certificate \"\xC2?\")");
  EXPECT_EQ(text("M\xC3\xBCller"), " (role \"r\", certificate \"M\xC3\xBCller\")");
  EXPECT_EQ(text(std::string(65, 'x')),
            " (role \"r\", certificate \"" + std::string(64, 'x') + "...\")");
}

}  // namespace
}  // namespace mbgate::report
