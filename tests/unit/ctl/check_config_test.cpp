// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <sstream>

#include "ctl/request/carry_out.hpp"

namespace mbgate::ctl {
namespace {

const std::string kConfigurations = MBGATE_SOURCE_DIR "/tests/config";

struct CheckPrinted {
  int status;
  std::string output;
  std::string errors;
};

CheckPrinted check_file(const std::string& file) {
  CheckCommand command;
  command.config = file;
  command.folder = kConfigurations + "/profiles";
  std::ostringstream out;
  std::ostringstream errors;
  const int status = carry_out(command, out, errors);
  return {status, out.str(), errors.str()};
}

TEST(CheckConfig, CountsWhatIsConfigured) {
  const auto checked = check_file(kConfigurations + "/valid/minimal.toml");
  EXPECT_EQ(checked.status, 0);
  EXPECT_EQ(checked.output,
            "configuration ok: 1 listener, 1 bus, 0 devices, 0 routes\n"
            "bus line-a: writes have 2803ms by default; a stop is sent within 1174ms\n"
            "needs the group dialout: /dev/ttyS0\n");
  EXPECT_EQ(checked.errors, "");
}

TEST(CheckConfig, ShowsAWarningAndIsContent) {
  const std::string file = kConfigurations + "/valid/warning-unused-bus.toml";
  const auto checked = check_file(file);
  EXPECT_EQ(checked.status, 0);
  EXPECT_EQ(checked.output,
            "configuration ok: 1 listener, 2 buses, 0 devices, 0 routes\n"
            "bus line-a: writes have 2803ms by default; a stop is sent within 1174ms\n"
            "bus line-b: writes have 2803ms by default; a stop is sent within 1174ms\n"
            "needs the group dialout: /dev/ttyS0, /dev/ttyS1\n");
  EXPECT_EQ(checked.errors, file +
                                ":13:8: warning: no listener and no route leads to this bus\n"
                                "name = \"line-b\"\n"
                                "       ^\n");
}

TEST(CheckConfig, NamesThePlaceOfAnError) {
  const std::string file = kConfigurations + "/invalid/syntax-value.toml";
  const auto checked = check_file(file);
  EXPECT_EQ(checked.status, 78);
  EXPECT_EQ(checked.output, "");
  EXPECT_EQ(checked.errors, file +
                                ":7:11: error: syntax: expected a value: a number, true, false, or "
                                "a string in quotes\n"
                                "ordered = yes\n"
                                "          ^\n");
}

TEST(CheckConfig, SaysThatThereIsNoFile) {
  const auto checked = check_file("no-such-folder/mbgate.toml");
  EXPECT_EQ(checked.status, 78);
  EXPECT_EQ(checked.output, "");
  EXPECT_EQ(checked.errors,
            "no-such-folder/mbgate.toml: error: cannot be read: No such file or directory\n");
}

TEST(CheckConfig, LooksForProfilesInTheFolderThatIsGiven) {
  const auto checked = check_file(kConfigurations + "/valid/drives.toml");
  EXPECT_EQ(checked.status, 0) << checked.errors;
}

}  // namespace
}  // namespace mbgate::ctl
