// SPDX-License-Identifier: Apache-2.0
#include "app/recording.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <fstream>
#include <iterator>

namespace mbgate::app {
namespace {

namespace fs = std::filesystem;

std::string content_of(const fs::path& file) {
  std::ifstream stream(file);
  return {std::istreambuf_iterator<char>(stream), {}};
}

class RecordingTest : public testing::Test {
 protected:
  RecordingTest() { fs::create_directory(folder_); }
  void TearDown() override { fs::remove_all(folder_); }

  fs::path folder_ = fs::temp_directory_path() / ("mbgate-recording-" + std::to_string(::getpid()));
};

TEST(RecordingPath, IsBelowTheStateDirectoryIfThereIsOne) {
  EXPECT_EQ(recording_path("a.rec", nullptr), "a.rec");
  EXPECT_EQ(recording_path("a.rec", ""), "a.rec");
  EXPECT_EQ(recording_path("a.rec", "/var/lib/mbgate"), "/var/lib/mbgate/a.rec");
  EXPECT_EQ(recording_path("a.rec", "/var/lib/mbgate:/var/lib/other"), "/var/lib/mbgate/a.rec");
  EXPECT_EQ(recording_path("/srv/a.rec", "/var/lib/mbgate"), "/srv/a.rec");
}

TEST_F(RecordingTest, CanBeReadByItsOwnerOnly) {
  ASSERT_TRUE(create_recording(folder_ / "a.rec"));
  EXPECT_EQ(fs::status(folder_ / "a.rec").permissions(), fs::perms(0600));
}

TEST_F(RecordingTest, KeepsTheOneBefore) {
  std::ofstream(folder_ / "a.rec") << "before";
  ASSERT_TRUE(create_recording(folder_ / "a.rec"));
  EXPECT_EQ(content_of(folder_ / "a.rec"), "");
  EXPECT_EQ(content_of(folder_ / "a.rec.1"), "before");
}

TEST(RecordedFiles, HavePathsThatHoldInEveryFolder) {
  const auto files = recorded_files({{"mbgate.toml", "a\n"}, {"/srv/conf.d/x.toml", ""}});
  ASSERT_EQ(files.size(), 2U);
  EXPECT_EQ(files[0].path, (fs::current_path() / "mbgate.toml").string());
  EXPECT_EQ(files[0].text, "a\n");
  EXPECT_EQ(files[1].path, "/srv/conf.d/x.toml");
}

TEST_F(RecordingTest, OfTheServiceHasAPlaceOfItsOwn) {
  EXPECT_EQ(recording_failure("/srv/plant/a.rec", EROFS),
            "cannot create the recording /srv/plant/a.rec: Read-only file system; the user that "
            "mbgated runs as must be able to write into /srv/plant (of the service: "
            "ReadWritePaths=), or name a FILE without a folder, which goes to the state directory, "
            "/var/lib/mbgate");
}

TEST_F(RecordingTest, NamesTheFileThatCannotBeMade) {
  const auto created = create_recording(folder_ / "missing" / "a.rec");
  ASSERT_FALSE(created);
  EXPECT_EQ(created.error(), "cannot create the recording " +
                                 (folder_ / "missing" / "a.rec").string() +
                                 ": No such file or directory");
}

}  // namespace
}  // namespace mbgate::app
