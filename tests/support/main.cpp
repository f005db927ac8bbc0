// SPDX-License-Identifier: Apache-2.0
// The main function of every test program. ctest runs each file by itself: --file=bus_test.cpp.
// A file without cases is an error, and so is a case where ctest would not look for it: nothing is
// left out unseen. What an emulator cannot run is named in emulated.txt (--emulated=FILE) and told.
#include <gmock/gmock.h>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

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

constexpr int kSkipped = 77;

/// The patterns in the file, one a line but those of "#"; nothing if it cannot be read.
std::optional<std::string> patterns_in(const std::string& path) {
  std::ifstream file(path);
  std::string patterns;
  for (std::string line; std::getline(file, line);) {
    if (!line.empty() && line.front() != '#') {
      patterns += (patterns.empty() ? "" : ":") + line;
    }
  }
  return patterns.empty() ? std::nullopt : std::optional(patterns);
}

/// Runs what is left without those patterns, and tells how much was left out.
int run_without(const std::string& patterns) {
  const std::string filter = GTEST_FLAG_GET(filter);
  GTEST_FLAG_SET(filter, filter + "-" + patterns);
  const int result = RUN_ALL_TESTS();
  const auto& all = *testing::UnitTest::GetInstance();
  const auto named = static_cast<int>(std::ranges::count(filter, '.'));
  const int left_out = named - all.test_to_run_count();
  if (left_out > 0) {
    std::printf("skipped: %d of %d cases, which the emulator cannot run (tests/emulated.txt)\n",
                left_out, named);
  }
  return result == 0 && all.test_to_run_count() == 0 ? kSkipped : result;
}

int run(const std::string& emulated) {
  if (emulated.empty()) {
    return RUN_ALL_TESTS();
  }
  const auto patterns = patterns_in(emulated);
  if (!patterns) {
    std::fprintf(stderr, "no patterns in %s\n", emulated.c_str());
    return 2;
  }
  return run_without(*patterns);
}

/// Takes "--NAME=VALUE" out of the arguments; "" if it is not there.
std::string take(std::vector<std::string>& arguments, std::string_view name) {
  for (auto it = arguments.begin(); it != arguments.end(); ++it) {
    if (it->starts_with(name)) {
      std::string value = it->substr(name.size());
      arguments.erase(it);
      return value;
    }
  }
  return {};
}

}  // namespace

int main(int count, char** arguments) {
  testing::InitGoogleMock(&count, arguments);
  std::vector<std::string> options(arguments + 1, arguments + count);
  const std::string file = take(options, "--file=");
  const std::string emulated = take(options, "--emulated=");
  if (!options.empty()) {
    std::fprintf(stderr, "usage: %s [--file=NAME_test.cpp [--emulated=FILE]] [--gtest_...]\n",
                 arguments[0]);
    return 2;
  }
  if (!file.empty()) {
    const auto filter = filter_of(file);
    if (!filter || filter->empty()) {
      std::fprintf(stderr, "no cases for %s\n", file.c_str());
      return 2;
    }
    GTEST_FLAG_SET(filter, *filter);
  }
  return run(emulated);
}
