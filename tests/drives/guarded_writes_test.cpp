// SPDX-License-Identifier: Apache-2.0
// Which writes the profiles guard because they lose a drive, and that the writes beside them pass.
#include <gmock/gmock.h>

#include "drives/drive_bench.hpp"

namespace mbgate::test {
namespace {

struct GuardedCase {
  std::string profile;
  std::vector<std::string> losing;
  std::vector<std::string> others;
};

const std::vector<GuardedCase>& guarded_cases() {
  // 40139 and 40145 are PM of one register.
  static const std::vector<std::string> losing_139{"06 008A 0007", "06 008A 000B", "06 008A 0000"};
  static const std::vector<std::string> others_139{"06 008A 0008", "06 008A 0009", "06 008A 000A"};
  static const std::vector<std::string> losing_145{"06 0090 0007", "06 0090 000B", "06 0090 0408"};
  static const std::vector<std::string> others_145{"06 0090 0008", "06 0090 0009", "06 0090 000A"};
  static const std::vector<GuardedCase> cases{
      {"rs485-stepper",
       {"06 00DC 0000", "10 00DB 0003 06 0001 0000 0001", "06 0012 0400", "06 0012 FFFF"},
       {"06 00DC 0001", "06 0012 FBFF", "06 00C8 0000"}},
      {"higen-fda6000", {"06 00DF 0001", "10 00DE 0002 04 0000 0001"}, {"06 00DF 0000"}},
      {"moons-stb", losing_139, others_139},
      {"moons-stf", losing_139, others_139},
      {"moons-ssdc", losing_139, others_139},
      {"moons-m2", losing_145, others_145},
      {"moons-mdx", losing_145, others_145},
      {"moons-m3",
       {"10 010A 0002 04 0000 0007", "10 010A 0002 04 0000 000B", "10 010A 0002 04 0008 0000",
        "06 010B 0009"},
       {"10 010A 0002 04 0000 0008", "10 010A 0002 04 0000 000A"}},
  };
  return cases;
}

TEST(GuardedWrites, AreThoseThatLoseADrive) {
  const auto answer_to = [](const std::string& profile, const std::string& request) {
    MachineRig rig(route_to(device_with(profile, WordOrder::little), WordOrder::big));
    rig.connect(1);
    const auto pdu = unhex(request);
    char head[32];
    std::snprintf(head, sizeof head, "0001 0000 %04X 01 ", static_cast<unsigned>(pdu.size() + 1));
    rig.receive(1, head + request);
    return rig.take_transmitted().empty() ? hex(unhex(rig.take_sent(1).at(0))) : "sent";
  };
  for (const auto& [profile, losing, others] : guarded_cases()) {
    for (const std::string& request : losing) {
      EXPECT_THAT(answer_to(profile, request), testing::EndsWith(" 01")) << profile << request;
    }
    for (const std::string& request : others) {
      EXPECT_EQ(answer_to(profile, request), "sent") << profile << ' ' << request;
    }
  }
}

TEST(ResponseTimeouts, OfTheDrivesOfTheManualsAreShort) {
  for (const auto* const profile :
       {"rs485-stepper", "higen-fda6000", "autonics-aic", "moons-st", "moons-stb", "moons-stf",
        "moons-ssdc", "moons-m2", "moons-m3", "moons-mdx", "moons-bldc"}) {
    EXPECT_EQ(shipped_profile(profile).profile.response_timeout, 300ms) << profile;
  }
  EXPECT_EQ(shipped_profile("generic").profile.response_timeout, std::nullopt);
}

}  // namespace
}  // namespace mbgate::test
