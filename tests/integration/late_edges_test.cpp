// SPDX-License-Identifier: Apache-2.0
// Late responses over real ptys, aimed at the end of the quarantine, when the second client's
// request leaves. On a busy machine only two clocks tell which came first: that of the device, when
// its answer could be read, and that of the machine, in its recording, from when on it looked at
// the line before it transmitted.
#include <fstream>
#include <map>
#include <sstream>

#include "integration/late_rig.hpp"

namespace mbgate::test {
namespace {

using Clock = ScriptedDevices::Clock;

constexpr auto kQuarantine = 100ms;
/// Counted as the devices do, from the end of the request. Adapters keep bytes for 20 ms.
constexpr auto kEndOfQuarantine = kResponseTimeout + kQuarantine + 20ms;
constexpr unsigned kOthers = 20'000;

struct Aimed {
  int line;
  unsigned number;
  std::optional<Clock::time_point> readable_at;  ///< the late answer; nothing: after the request
  bool is_confused;                              ///< it was taken for the answer to that
};

/// From when on the machine looked at the line before it transmitted, by line and request: because
/// it wanted to, or because a deadline is handed in only afterwards.
class Looks {
 public:
  explicit Looks(const std::filesystem::path& recording) {
    std::ifstream stream(recording);
    for (std::string line; std::getline(stream, line);) {
      std::istringstream words(line);
      std::string first;
      std::string what;
      int bus = -1;
      std::string frame;
      words >> first >> what >> bus >> frame;
      if (first != "<") {
        at_ = std::strtoll(first.c_str(), nullptr, 10);
        is_deadline_ = what == "time";
      } else if (what == "look") {
        asked_[bus] = at_;
      } else if (what == "transmit") {
        before_.emplace(std::pair(bus, frame.substr(0, 12)), is_deadline_ ? at_ : asked_[bus]);
      }
    }
  }
  /// Before the first transmission of the read of one register.
  [[nodiscard]] std::optional<Clock::time_point> before(int line, unsigned address) const {
    const auto found = before_.find({line, "0103" + hex16(address) + "0001"});
    return found == before_.end()
               ? std::nullopt
               : std::optional(Clock::time_point(std::chrono::nanoseconds(found->second)));
  }

 private:
  std::int64_t at_ = 0;
  bool is_deadline_ = false;
  std::map<int, std::int64_t> asked_;
  std::map<std::pair<int, std::string>, std::int64_t> before_;
};

class LateEdges : public LateRig {
 protected:
  // From 4.5 ms before to 1.5 ms after it.
  void aim(int line, int number, TcpClient& first, TcpClient& second, Tally& tally) {
    const auto place = static_cast<unsigned>(number);
    const Question late{place, 1};
    const Question other{place + kOthers, 1};
    std::deque<ScriptedDevices::Delay> answers(static_cast<std::size_t>(retries_of(line)));
    answers.emplace_back(kEndOfQuarantine + number / kLateLines * 790us % 6ms - 4500us);
    devices_.plan(line, late.address, std::move(answers));
    ask(line, first, late, place);
    judge(line, first.receive(), {late, place}, tally.exceptions, tally);
    ask(line, second, other, place);
    const auto got = second.receive();
    const bool is_confused = got && *got == late.answer(place);
    if (is_confused) {
      forget(line, other);
    } else {
      judge(line, got, {other, place}, tally.second_exceptions, tally);
    }
    ASSERT_TRUE(devices_.all_given(line));
    {
      const std::lock_guard lock(mutex_);
      aimed_.push_back({line, place, devices_.readable_at(line), is_confused});
    }
    if (!got || *got != other.answer(place)) {
      // Its own answer is still to come; what that does to later ones is not judged.
      std::this_thread::sleep_for(kEndOfQuarantine);
    }
  }
  void aim_all(const std::string& wake_early, int& lay_there) {
    const int tries = tries_or(48);
    start(100ms, "quarantine = \"100ms\"\nquarantine_max = \"100ms\"\noffline_after = 0\n",
          "[gateway]\nwake_early = \"" + wake_early + "\"\n", {"--record", "late.rec"});
    aimed_.clear();
    const Tally tally = run(tries, [this](auto&&... with) { aim(with...); });
    gateway_->signal(SIGTERM);
    ASSERT_EQ(gateway_->wait_for_exit(), 0);
    const Looks looks(folder_.path() / "late.rec");
    std::filesystem::remove(folder_.path() / "late.rec");
    int wrong = 0;
    int unavoidable = 0;
    for (const Aimed& it : aimed_) {
      const auto looked = looks.before(it.line, it.number + kOthers);
      ASSERT_TRUE(looked) << it.number;
      const bool is_before = it.readable_at && *it.readable_at < *looked;
      lay_there += is_before ? 1 : 0;
      wrong += is_before && it.is_confused ? 1 : 0;
      unavoidable += !is_before && it.is_confused ? 1 : 0;
    }
    std::printf(
        "wake_early %s: %d lay there before the look, of these %d WRONG; %d came too late "
        "to tell\n",
        wake_early.c_str(), lay_there, wrong, unavoidable);
    ASSERT_EQ(tally.tries, tries);
    EXPECT_EQ(tally.wrong + wrong, 0) << wake_early;
    EXPECT_EQ(tally.missing, 0) << wake_early;
  }

 private:
  std::mutex mutex_;
  std::vector<Aimed> aimed_;
};

// What could be read before the machine looked is no answer to what it transmitted then; what came
// in the same instant, no gateway can tell.
TEST_F(LateEdges, WhatLiesInTheLineIsNoAnswerToTheNextRequest) {
  for (const char* wake_early : {"0ms", "100us", "1ms"}) {
    // On a machine so busy that every answer came after the look, nothing was shown yet.
    int lay_there = 0;
    for (int times = 0; lay_there == 0 && times < 20; ++times) {
      aim_all(wake_early, lay_there);
      ASSERT_FALSE(HasFailure());
    }
    EXPECT_GT(lay_there, 0) << wake_early;
  }
}

}  // namespace
}  // namespace mbgate::test
