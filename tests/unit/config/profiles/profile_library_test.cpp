// SPDX-License-Identifier: Apache-2.0
#include "config/profiles/profile_library.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>

#include "support/config_text.hpp"

namespace mbgate::config {
namespace {

using testing::Contains;
using testing::ElementsAre;
namespace fs = std::filesystem;

const fs::path kSource(MBGATE_SOURCE_DIR);
const fs::path kProfiles = kSource / "tests/config/profiles";
const fs::path kInvalid = kSource / "tests/config/profiles-invalid";

TEST(ProfileLibrary, ReadsAProfileOnce) {
  ProfileLibrary library({kProfiles});
  EXPECT_TRUE(library.knows("settable"));
  const auto* first = library.find("settable");
  ASSERT_NE(first, nullptr);
  EXPECT_EQ(first->profile.name, "settable");
  EXPECT_EQ(library.find("settable"), first);
  EXPECT_TRUE(library.diagnostics().empty());
}

TEST(ProfileLibrary, ReportsAWrongProfileOnce) {
  ProfileLibrary library({kProfiles});
  EXPECT_TRUE(library.knows("wrong"));
  EXPECT_EQ(library.find("wrong"), nullptr);
  EXPECT_EQ(library.find("wrong"), nullptr);
  EXPECT_EQ(render(library.diagnostics()),
            (kProfiles / "wrong.toml").string() +
                ":6:14: error: word_order: expected \"big\", \"little\" or \"settable\", found "
                "\"litle\"; did you mean 'little'?\nword_order = \"litle\"\n             ^\n");
}

TEST(ProfileLibrary, TakesTheFirstFolderThatHasAProfile) {
  const auto folder =
      fs::path(testing::TempDir()) /
      ("mbgate-profiles-" + std::to_string(testing::UnitTest::GetInstance()->random_seed()) + "-" +
       std::to_string(::getpid()));
  fs::create_directories(folder);
  std::ofstream(folder / "aic.toml")
      << "name = \"aic\"\ndescription = \"mine\"\nmanual = \"None\"\n";
  ProfileLibrary library({folder, kProfiles});
  const auto* mine = library.find("aic");
  const auto* shipped = library.find("fixed");
  fs::remove_all(folder);
  ASSERT_NE(mine, nullptr);
  EXPECT_EQ(mine->description, "mine");
  ASSERT_NE(shipped, nullptr);
  EXPECT_THAT(library.names(),
              ElementsAre("aic", "bits", "fixed", "generic", "settable", "short", "wrong"));
}

TEST(ProfileLibrary, KnowsNoPaths) {
  ProfileLibrary library({kInvalid});
  for (const auto* name : {"../profiles/fixed", "", ".", "..", "/etc/passwd"}) {
    EXPECT_FALSE(library.knows(name)) << name;
    EXPECT_EQ(library.find(name), nullptr) << name;
  }
  EXPECT_TRUE(library.diagnostics().empty());
}

TEST(ProfileLibrary, HasTheGenericProfileWithoutAnyFolder) {
  ProfileLibrary library({"no-such-folder", "nor-this"});
  EXPECT_TRUE(library.knows("generic"));
  ASSERT_NE(library.find("generic"), nullptr);
  EXPECT_THAT(library.names(), ElementsAre("generic"));
  EXPECT_EQ(unknown_profile(library, "moons-m3"),
            "no profile is named \"moons-m3\"; there is only \"generic\" in no-such-folder and "
            "nor-this");
}

/// This test runs from its build folder; an installed program does not (see the package's tests).
TEST(DefaultProfileFolders, AreTheSourceTreesInABuildFolder) {
  EXPECT_THAT(default_profile_folders(),
              ElementsAre(std::filesystem::canonical(kSource / "conf/profiles")));
}

constexpr std::string_view kConfiguration = R"(
[[listen]]
name = "service"
port = 0
bus = "line-a"
[[bus]]
name = "line-a"
device = "/dev/ttyS0"
[[device]]
name = "axis-x"
bus = "line-a"
address = 1
profile = "aic"
[[device]]
name = "axis-y"
bus = "line-a"
address = 2
profile = "aic"
[gateway]
)";

std::string with_profile(const std::string& name) {
  std::string text(kConfiguration);
  for (auto at = text.find("\"aic\""); at != std::string::npos; at = text.find("\"aic\"")) {
    text.replace(at, 5, '"' + name + '"');
  }
  return text;
}

TEST(LoadSettings, FindsProfilesBesideTheConfiguration) {
  const auto path = (kSource / "tests/config/valid/x.toml").string();
  const auto text = with_profile("fixed") + "profiles = \"../profiles\"\n";
  const auto loaded = test::load_settings_text(path, text, {.otherwise = {kInvalid}});
  EXPECT_EQ(render(loaded.diagnostics), "");
  ASSERT_TRUE(loaded.settings);
  EXPECT_EQ(loaded.settings->devices[1].profile.name, "fixed");
}

TEST(LoadSettings, PrefersTheFolderOfTheCommandLine) {
  const auto text = with_profile("fixed") + "profiles = \"" + kInvalid.string() + "\"\n";
  const auto loaded =
      test::load_settings_text("x.toml", text, {.folder = kProfiles, .otherwise = {kInvalid}});
  EXPECT_EQ(render(loaded.diagnostics), "");
  EXPECT_TRUE(loaded.settings);
}

TEST(LoadSettings, ReportsAWrongProfileOnceWithItsOwnFile) {
  const auto loaded =
      test::load_settings_text("x.toml", with_profile("wrong"), {.otherwise = {kProfiles}});
  ASSERT_EQ(loaded.diagnostics.size(), 1U);
  EXPECT_EQ(loaded.diagnostics[0].file, (kProfiles / "wrong.toml").string());
  EXPECT_FALSE(loaded.settings);
}

}  // namespace
}  // namespace mbgate::config
