// SPDX-License-Identifier: Apache-2.0
// A file that takes what it is given, one that is full, and one that takes nothing.
#include "io/recorder.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>

#include <array>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <vector>

namespace mbgate::io {
namespace {

constexpr gateway::Instant kAt{bus::Duration{500}};
constexpr std::chrono::seconds kPatience{30};

class RecorderTest : public testing::Test {
 protected:
  RecorderTest()
      : path_(std::filesystem::temp_directory_path() /
              ("mbgate-recorder-" + std::to_string(::getpid()))) {}
  ~RecorderTest() override { std::filesystem::remove(path_); }

  Recorder::OnEnded note_end() {
    return [this](const std::string& why) { ended_.push_back(why); };
  }
  [[nodiscard]] sys::UniqueFd file() const {
    return sys::UniqueFd(::open(path_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600));
  }
  [[nodiscard]] std::string written() const {
    std::ifstream stream(path_);
    return {std::istreambuf_iterator<char>(stream), {}};
  }

  std::filesystem::path path_;
  std::vector<std::string> ended_;
};

TEST_F(RecorderTest, WritesWhatItIsGivenInOrder) {
  Recorder recorder(file(), "mbgate recording 1\n", note_end());
  recorder.begin(kAt);
  recorder.note(gateway::LineOpened{gateway::BusId{0}}, kAt);
  recorder.note(gateway::Open{gateway::BusId{1}}, {});
  recorder.hand_over();
  recorder.note(gateway::DeadlineReached{}, kAt);
  EXPECT_TRUE(recorder.close(kPatience));
  recorder.note(gateway::DeadlineReached{}, kAt);
  EXPECT_EQ(written(), "mbgate recording 1\n500 start\n500 opened 0 virtual\n< open 1\n500 time\n");
  EXPECT_TRUE(ended_.empty());
}

TEST_F(RecorderTest, SaysInTheFileWhyItEnded) {
  Recorder recorder(file(), "", note_end());
  recorder.note(gateway::DeadlineReached{}, kAt);
  recorder.end("the settings are others from here on");
  recorder.note(gateway::DeadlineReached{}, kAt);
  EXPECT_TRUE(recorder.close(kPatience));
  EXPECT_EQ(written(), "500 time\nend the settings are others from here on\n");
  EXPECT_TRUE(ended_.empty());
}

TEST_F(RecorderTest, EndsWhenTheFileCannotBeWritten) {
  Recorder recorder(sys::UniqueFd(::open("/dev/full", O_WRONLY | O_CLOEXEC)), "", note_end());
  while (ended_.empty()) {
    recorder.note(gateway::DeadlineReached{}, kAt);
    recorder.hand_over();
  }
  EXPECT_EQ(ended_, std::vector<std::string>{"it cannot be written: No space left on device"});
  EXPECT_FALSE(recorder.close(kPatience));
}

TEST_F(RecorderTest, EndsRatherThanGrowWhenTheFileTakesNothing) {
  std::array<int, 2> ends{};
  ASSERT_EQ(::pipe2(ends.data(), O_CLOEXEC), 0);
  const sys::UniqueFd nobody_reads(ends[0]);
  Recorder recorder(sys::UniqueFd(ends[1]), "", note_end());
  const std::vector<std::uint8_t> bytes(2048);
  std::size_t noted = 0;
  for (; ended_.empty() && noted < 3 * Recorder::kMostWaiting; noted += 2 * bytes.size()) {
    recorder.note(gateway::LineBytes{gateway::BusId{0}, bytes}, kAt);
    recorder.hand_over();
  }
  EXPECT_EQ(ended_, std::vector<std::string>{"it cannot be written as fast as it grows"});
  // What waits, and what the writer took before the pipe was full: no more than that either.
  EXPECT_LE(noted, 2 * Recorder::kMostWaiting + 2 * bytes.size());
  EXPECT_FALSE(recorder.close(std::chrono::milliseconds(0)));
}

}  // namespace
}  // namespace mbgate::io
