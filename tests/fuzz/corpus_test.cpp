// SPDX-License-Identifier: Apache-2.0
// Every input of the corpora again, without a fuzzer: what was found once stays found.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>

#include "fuzz/fuzz.hpp"

MBGATE_FUZZ_TARGET(mbap);
MBGATE_FUZZ_TARGET(rtu_framer);
MBGATE_FUZZ_TARGET(ascii_framer);
MBGATE_FUZZ_TARGET(plan);
MBGATE_FUZZ_TARGET(config);
MBGATE_FUZZ_TARGET(rules);
MBGATE_FUZZ_TARGET(profile);
MBGATE_FUZZ_TARGET(machine);
MBGATE_FUZZ_TARGET(plant);
MBGATE_FUZZ_TARGET(role);
MBGATE_FUZZ_TARGET(http);
MBGATE_FUZZ_TARGET(recording);

namespace mbgate::fuzz {
namespace {

namespace fs = std::filesystem;
using Target = int (*)(const std::uint8_t*, std::size_t);

const std::map<std::string, Target> kTargets{{"mbap", fuzz_mbap},
                                             {"rtu_framer", fuzz_rtu_framer},
                                             {"ascii_framer", fuzz_ascii_framer},
                                             {"plan", fuzz_plan},
                                             {"config", fuzz_config},
                                             {"profile", fuzz_profile},
                                             {"machine", fuzz_machine},
                                             {"plant", fuzz_plant},
                                             {"http", fuzz_http},
                                             {"recording", fuzz_recording},
                                             {"role", fuzz_role},
                                             {"rules", fuzz_rules}};

fs::path corpora() { return fs::path(MBGATE_SOURCE_DIR) / "tests/fuzz/corpus"; }

class FuzzCorpus : public testing::TestWithParam<std::pair<const std::string, Target>> {};

TEST_P(FuzzCorpus, HoldsWhatItHeldBefore) {
  const auto& [name, target] = GetParam();
  target(nullptr, 0);
  std::size_t inputs = 0;
  for (const auto& entry : fs::directory_iterator(corpora() / name)) {
    std::ifstream file(entry.path(), std::ios::binary);
    const std::vector<char> bytes(std::istreambuf_iterator<char>(file), {});
    SCOPED_TRACE(entry.path());
    target(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
    ++inputs;
  }
  EXPECT_GT(inputs, 0U);
}

INSTANTIATE_TEST_SUITE_P(, FuzzCorpus, testing::ValuesIn(kTargets),
                         [](const auto& target) { return target.param.first; });

TEST(FuzzCorpora, HaveATargetEach) {
  for (const auto& entry : fs::directory_iterator(corpora())) {
    EXPECT_TRUE(kTargets.contains(entry.path().filename())) << entry.path();
  }
}

}  // namespace
}  // namespace mbgate::fuzz
