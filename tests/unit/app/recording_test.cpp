// SPDX-License-Identifier: Apache-2.0
#include "app/recording.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <fstream>

namespace mbgate::app {
namespace {

namespace fs = std::filesystem;

class RecordingTest : public testing::Test {
 protected:
  RecordingTest() { fs::create_directory(folder_); }
  ~RecordingTest() override { fs::remove_all(folder_); }

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
  EXPECT_EQ(read_text(folder_ / "a.rec"), "");
  EXPECT_EQ(read_text(folder_ / "a.rec.1"), "before");
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
