// SPDX-License-Identifier: Apache-2.0
// `mbgatectl profile`: what people and programs are shown of the profiles in tests/config/profiles.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <boost/json.hpp>
#include <sstream>

#include "ctl/request/carry_out.hpp"

namespace mbgate::ctl {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

const std::string kFolder = MBGATE_SOURCE_DIR "/tests/config/profiles";

struct Shown {
  int status;
  std::string out;
  std::string errors;
};

Shown show(const std::string& which, bool json = false, const std::string& folder = kFolder) {
  std::ostringstream out;
  std::ostringstream errors;
  const int status = carry_out(ProfileCommand{which, folder, json}, out, errors);
  return {status, out.str(), errors.str()};
}

std::string member(const boost::json::value& object, std::string_view key) {
  return boost::json::serialize(object.at({key.data(), key.size()}));
}

constexpr std::string_view kSettable = R"(
  addresses       1-32 on a serial line
  functions       3, 4, 6, 16
  accepts with    exception 0x05 (acknowledge)
  reads at most   50 holding registers, 50 input registers
  writes at most  40 holding registers
  word order      set at the drive: 40081 holds 5 when big, 133 when little (line 82)
  response wait   4ms
  broadcasts      at address 0

Stop commands
  address  manual  written                            line  name
  70       40071   = 0x00E1, with up to 3 parameters  72    Stop
  71       40072   & 0x0001 = 0x0000                  73    End jogging

Writes that are never answered
  address  manual  written                     deaf for  line  name
  91       40092   & 0xFF00 other than 0x0000  2s        92    Restart

Slow registers
  table    address  manual  response timeout  line  name
  holding  90       40091   3s                91    Save

Communication registers, guarded unless allow_reconfigure = true
  table    address  manual  line  name
  holding  80       40081   81    Protocol

Opcodes with a position (word order: opcode_order of the device)
  opcode in      40071
  opcodes        0x0098
  position from  40073 (line 74)

32-bit values in holding registers: 2
  address  manual  access  line  name
  10       40011   r       11    Position
  30       40031   rw      31    Distance; starts motion

32-bit values in input registers: 1
  address  manual  access  line  name
  0        30001   rw      1     Speed

64-bit values in holding registers: 1
  address  manual  access  line  name
  50       40051   rw      51    Counter

Write-only registers besides values
  table    address  manual       line  name
  holding  70-71    40071-40072  71    Commands

Strings, never exchanged
  table    address  manual       line  name
  holding  40-43    40041-40044  41    Model

Parameter groups (no request crosses a border)
  table    address  manual       line  name
  holding  0-99     40001-40100
  holding  100-200  40101-40201
)";

TEST(Profile, IsShownWhole) {
  const auto shown = show("settable");
  EXPECT_EQ(shown.status, 0);
  EXPECT_EQ(shown.errors, "");
  EXPECT_EQ(shown.out, "settable: A drive for tests\n  manual          None\n  file            " +
                           kFolder + "/settable.toml" + std::string(kSettable));
}

TEST(Profile, ShowsFixedOrdersAndBroadcasts) {
  EXPECT_THAT(show("fixed").out,
              HasSubstr("  reads at most   125 holding registers, 1 input register\n"
                        "  writes at most  123 holding registers, preferably with function 16\n"
                        "  function 4      reads the holding registers\n"
                        "  word order      little: low word first\n"));
  EXPECT_THAT(show("aic").out,
              HasSubstr("  broadcasts      at address 129, with function codes OR 0x80, at most 2 "
                        "registers, only to coils 0x000B-0x001B\n"));
  EXPECT_THAT(show("generic").out, HasSubstr("  functions       all\n"));
}

TEST(Profile, MayBeAFile) {
  EXPECT_EQ(show(kFolder + "/aic.toml", false, "/").out, show("aic").out);
}

TEST(Profile, ThatIsUnknownOrWrongIsReported) {
  const auto unknown = show("setable");
  EXPECT_EQ(unknown.status, 1);
  EXPECT_EQ(unknown.out, "");
  EXPECT_EQ(unknown.errors,
            "mbgatectl: no profile is named \"setable\"; did you mean 'settable'?\n");
  for (const auto& which : {std::string("wrong"), kFolder + "/wrong.toml"}) {
    const auto wrong = show(which);
    EXPECT_EQ(wrong.status, 1);
    EXPECT_EQ(wrong.out, "");
    EXPECT_THAT(wrong.errors, StartsWith(kFolder + "/wrong.toml:6:14: error: word_order: "));
  }
}

TEST(ProfileList, NamesEveryGoodProfileAndReportsTheOthers) {
  const auto list = show("");
  EXPECT_EQ(list.status, 1);
  EXPECT_EQ(list.out,
            "  aic       A third drive for tests\n"
            "  bits      A fifth drive for tests\n"
            "  fixed     Another drive for tests\n"
            "  generic   Any Modbus device\n"
            "  settable  A drive for tests\n"
            "  short     A fourth drive for tests\n");
  EXPECT_THAT(list.errors, StartsWith(kFolder + "/wrong.toml:6:14: error: word_order: "));
}

TEST(ProfileList, IsAnArrayForPrograms) {
  const auto list = boost::json::parse(show("", true, MBGATE_SOURCE_DIR "/conf/profiles").out);
  ASSERT_GE(list.as_array().size(), 12U);
  EXPECT_EQ(member(list.as_array()[0], "name"), R"("autonics-aic")");
}

TEST(ProfileJson, HasTheAddressesOfValues) {
  const auto profile = boost::json::parse(show("settable", true).out);
  EXPECT_EQ(member(profile, "name"), R"("settable")");
  EXPECT_EQ(member(profile, "values32"), R"({"holding":[10,30],"input":[0]})");
  EXPECT_EQ(member(profile, "values64"), R"({"holding":[50],"input":[]})");
  EXPECT_EQ(member(profile, "strings"), R"({"holding":[40],"input":[]})");
  EXPECT_EQ(member(profile, "functions"), "[3,4,6,16]");
  EXPECT_EQ(member(profile, "acceptances"), "[5]");
  EXPECT_EQ(member(profile, "limits"),
            R"({"read_coils":2000,"read_discrete":2000,"read_holding":50,"read_input":50,)"
            R"("write_coils":1968,"write_registers":40})");
  EXPECT_EQ(member(profile, "word_order"), R"("settable")");
  EXPECT_EQ(member(profile, "response_wait"), R"("4ms")");
  EXPECT_EQ(member(profile, "word_order_register"), R"({"address":80,"big":[5],"little":[133]})");
  EXPECT_EQ(member(profile, "position_opcodes"), R"({"address":70,"opcodes":[152],"position":72})");
}

TEST(ProfileJson, HasWritesAndBroadcasts) {
  const auto settable = boost::json::parse(show("settable", true).out);
  EXPECT_EQ(
      member(settable, "stops"),
      R"([{"table":"holding","address":70,"mask":65535,"value":225,"parameters":3,"name":"Stop","line":72},)"
      R"({"table":"holding","address":71,"mask":1,"value":0,"parameters":0,"name":"End jogging","line":73}])");
  EXPECT_EQ(member(settable, "no_answer"),
            R"([{"table":"holding","address":91,"mask":65280,"not":0,"after":"2s",)"
            R"("name":"Restart","line":92}])");
  EXPECT_EQ(member(settable, "slow"),
            R"([{"table":"holding","first":90,"registers":1,"number":"40091",)"
            R"("response_timeout":"3s","name":"Save","line":91}])");
  EXPECT_EQ(member(settable, "broadcast"),
            R"({"form":"standard","most_registers":null,"allowed":null})");
  const auto aic = boost::json::parse(show("aic", true).out);
  EXPECT_EQ(member(aic, "broadcast"),
            R"({"form":"own","most_registers":2,"allowed":[{"table":"coils","first":11,)"
            R"("registers":17,"number":"0x000B","name":"","line":null}]})");
}

TEST(ProfileJson, HasWhatPeopleLookUp) {
  const auto profile = boost::json::parse(show("settable", true).out);
  EXPECT_EQ(boost::json::serialize(profile.at("entries").at("values").as_array().at(1)),
            R"({"table":"holding","first":30,"registers":2,"number":"40031","access":"rw",)"
            R"("motion":true,"name":"Distance","line":31})");
  EXPECT_EQ(member(profile, "file"), "\"" + kFolder + "/settable.toml\"");
}

}  // namespace
}  // namespace mbgate::ctl
