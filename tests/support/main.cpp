// SPDX-License-Identifier: Apache-2.0
// The main function of every test program. ctest runs each file by itself: --file=bus_test.cpp.
// A file without cases is an error, and so is a case where ctest would not look for it: nothing is
// left out unseen.
#include <gmock/gmock.h>

#include <cstdio>
#include <optional>
#include <string>
#include <string_view>

namespace {

std::string_view name_of(std::string_view path) { return path.substr(path.rfind('/') + 1); }

/// The full names of the cases in the file, as a filter; nothing if a case is in no test file.
std::optional<std::string> filter_of(std::string_view file) {
  const auto& all = *testing::UnitTest::GetInstance();
  std::string filter;
  for (int suite = 0; suite < all.total_test_suite_count(); ++suite) {
    const auto& cases = *all.GetTestSuite(suite);
    for (int number = 0; number < cases.total_test_count(); ++number) {
      const auto& it = *cases.GetTestInfo(number);
      if (!std::string_view(it.file()).ends_with("_test.cpp")) {
        std::fprintf(stderr, "%s.%s is in %s: cases belong into files named …_test.cpp\n",
                     it.test_suite_name(), it.name(), it.file());
        return std::nullopt;
      }
      if (file == name_of(it.file())) {
        filter += std::string(it.test_suite_name()) + "." + it.name() + ":";
      }
    }
  }
  return filter;
}

}  // namespace

int main(int count, char** arguments) {
  testing::InitGoogleMock(&count, arguments);
  constexpr std::string_view kFile = "--file=";
  const std::string_view argument = count == 2 ? arguments[1] : "";
  if (count > 2 || !(argument.empty() || argument.starts_with(kFile))) {
    std::fprintf(stderr, "usage: %s [--file=NAME_test.cpp] [--gtest_...]\n", arguments[0]);
    return 2;
  }
  if (!argument.empty()) {
    const auto filter = filter_of(argument.substr(kFile.size()));
    if (!filter || filter->empty()) {
      std::fprintf(stderr, "no cases for %s\n", arguments[1]);
      return 2;
    }
    GTEST_FLAG_SET(filter, *filter);
  }
  return RUN_ALL_TESTS();
}
