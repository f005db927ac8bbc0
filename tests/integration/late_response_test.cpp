// SPDX-License-Identifier: Apache-2.0
// Late responses over real ptys: a device answers its first client up to 300 ms after the response
// timeout, while a second client asks for other registers of it, as many and by the same function,
// so that nothing in the frames tells the answers apart. MBGATE_LATE_TRIES says how often. And
// answers aimed at the end of the quarantine, when the second client's request leaves.
#include <gtest/gtest.h>

#include <cstdlib>

#include "integration/plant.hpp"
#include "integration/scripted_devices.hpp"

namespace mbgate::test {
namespace {

using namespace std::chrono_literals;

constexpr int kLines = 8;  // the first half without retries, the other half with one
constexpr auto kResponseTimeout = 100ms;
constexpr int kLongestLateness = 300;
constexpr auto kQuarantine = 100ms;
/// Counted as the devices do, from the end of the request. Adapters keep bytes for 20 ms.
constexpr auto kEndOfQuarantine = kResponseTimeout + kQuarantine + 20ms;

enum class Aim : std::uint8_t { anywhere, end_of_quarantine };

int tries_or(int usual) {
  const char* const wanted = std::getenv("MBGATE_LATE_TRIES");
  return wanted == nullptr ? usual : std::atoi(wanted);
}

std::string hex16(unsigned value) {
  char text[8];
  std::snprintf(text, sizeof text, "%04X", value);
  return text;
}

std::string line_name(int line) { return "line-" + std::to_string(line); }

struct Tally {
  int tries = 0;
  int right = 0;
  int exceptions = 0;  // of the first client; the second one's are counted apart
  int second_exceptions = 0;
  int wrong = 0;
  int missing = 0;
  int lay_there = 0;    // the late answer, 1 ms before the next request
  int unavoidable = 0;  // of the others, those that were taken for the next one's answer
  void add(const Tally& other) {
    tries += other.tries;
    right += other.right;
    exceptions += other.exceptions;
    second_exceptions += other.second_exceptions;
    wrong += other.wrong;
    missing += other.missing;
    lay_there += other.lay_there;
    unavoidable += other.unavoidable;
  }
};

struct Question {
  unsigned address;
  unsigned count;
  [[nodiscard]] ByteString adu(unsigned transaction) const {
    return request(transaction, 1, "03" + hex16(address) + hex16(count));
  }
  [[nodiscard]] ByteString answer(unsigned transaction) const {
    std::string pdu = "03" + hex16(count * 2).substr(2);
    for (unsigned at = 0; at < count; ++at) {
      pdu += hex16(ScriptedDevices::value_of(address + at));
    }
    return request(transaction, 1, pdu);
  }
};

void judge(const std::optional<ByteString>& got, const Question& asked, unsigned transaction,
           int& exceptions, Tally& tally) {
  if (!got) {
    ++tally.missing;
  } else if (*got == asked.answer(transaction)) {
    ++tally.right;
  } else if (got->size() == 9 && (*got)[7] == 0x83) {
    ++exceptions;
  } else {
    ++tally.wrong;
  }
}

class LateResponses : public testing::Test {
 protected:
  void start(const std::string& quarantine, const std::string& gateway = "") {
    std::string text = gateway;
    for (int line = 0; line < kLines; ++line) {
      text += "[[listen]]\nname = \"" + line_name(line) + "\"\nport = 0\nbus = \"" +
              line_name(line) + "\"\n[[bus]]\nname = \"" + line_name(line) + "\"\ndevice = \"" +
              devices_.path(line) +
              "\"\nbaud = 115200\nparity = \"none\"\nlisten_first = \"0ms\"\n"
              "response_timeout = \"100ms\"\nretries = " +
              std::to_string(retries_of(line)) + "\n" + quarantine;
    }
    gateway_.emplace("mbgated",
                     std::vector<std::string>{"--config", folder_.write("mbgate.toml", text)},
                     Process::Options{folder_.path(), {}});
  }
  /// Shares the tries among the lines, which work side by side.
  Tally run(int tries, Aim aimed = Aim::anywhere) {
    std::vector<std::uint16_t> ports;
    for (int line = 0; line < kLines; ++line) {
      ports.push_back(gateway_->port_of(line_name(line)));
    }
    std::vector<Tally> tallies(kLines);
    std::vector<std::thread> threads;
    for (int line = 0; line < kLines; ++line) {
      threads.emplace_back([this, line, tries, aimed, port = ports[static_cast<std::size_t>(line)],
                            &tally = tallies[static_cast<std::size_t>(line)]] {
        TcpClient first(port);
        TcpClient second(port);
        for (int number = line; number < tries && !HasFailure(); number += kLines) {
          aimed == Aim::end_of_quarantine ? aim(line, number, first, second, tally)
                                          : attempt(line, number, first, second, tally);
        }
      });
    }
    for (std::thread& thread : threads) {
      thread.join();
    }
    Tally all;
    for (int retries = 0; retries < 2; ++retries) {
      Tally half;
      for (int line = 0; line < kLines; ++line) {
        if (retries_of(line) == retries) {
          half.add(tallies[static_cast<std::size_t>(line)]);
        }
      }
      std::printf(
          "retries %d: %d tries, %d answers right, %d exceptions of the late read, %d of the "
          "other, %d missing, %d WRONG\n",
          retries, half.tries, half.right, half.exceptions, half.second_exceptions, half.missing,
          half.wrong);
      all.add(half);
    }
    std::printf("answers that the machine was too slow to give: %u\n", devices_.missed());
    return all;
  }

  // The answer comes when the next request may leave: from 4.5 ms before to 1.5 ms after it.
  void aim(int line, int number, TcpClient& first, TcpClient& second, Tally& tally) {
    const Question late{static_cast<unsigned>(number % 1000) * 10, 1};
    const Question other{late.address + 20'000, 1};
    const auto transaction = static_cast<unsigned>(number) & 0xFFFFU;
    std::deque<ScriptedDevices::Delay> answers(static_cast<std::size_t>(retries_of(line)));
    answers.emplace_back(kEndOfQuarantine + number / kLines * 790us % 6ms - 4500us);
    devices_.plan(line, late.address, std::move(answers));
    first.send(late.adu(transaction));
    judge(first.receive(), late, transaction, tally.exceptions, tally);
    second.send(other.adu(transaction));
    const auto got = second.receive();
    const auto lay_there = devices_.lay_in_the_line(line);
    ASSERT_TRUE(lay_there);
    ++tally.tries;
    tally.lay_there += *lay_there ? 1 : 0;
    if (!*lay_there && got && *got == late.answer(transaction)) {
      ++tally.unavoidable;
      std::this_thread::sleep_for(kEndOfQuarantine);  // nor whose answer the next one is
    } else {
      judge(got, other, transaction, tally.second_exceptions, tally);
    }
  }

 private:
  static int retries_of(int line) { return line < kLines / 2 ? 0 : 1; }

  // One of the ways in which the answers of a read and of its retry can be late or missing.
  static std::deque<ScriptedDevices::Delay> delays(int variant, std::chrono::milliseconds late) {
    switch (variant % 4) {
      case 0: return {late, late};
      case 1: return {late, 2ms};
      case 2: return {std::nullopt, late};
      default: return {late, std::nullopt};
    }
  }

  void attempt(int line, int number, TcpClient& first, TcpClient& second, Tally& tally) {
    const int round = number / kLines;
    const auto lateness = std::chrono::milliseconds(1 + number * 7 % kLongestLateness);
    const unsigned count = 1 + static_cast<unsigned>(round) % 4;
    const Question late{static_cast<unsigned>(number % 1000) * 10, count};
    const Question other{late.address + 20'000, count};
    const auto transaction = static_cast<unsigned>(number) & 0xFFFFU;
    auto answers = delays(retries_of(line) == 0 ? 0 : round, kResponseTimeout + lateness);
    answers.resize(static_cast<std::size_t>(retries_of(line)) + 1);
    devices_.plan(line, late.address, std::move(answers));
    first.send(late.adu(transaction));
    // The other client comes while the first one waits, or when that has its answer.
    std::optional<ByteString> got;
    if (round / 2 % 2 == 0) {
      got = first.receive(number * 11 % 95);
    } else {
      got = first.receive();
    }
    second.send(other.adu(transaction));
    if (!got) {
      got = first.receive();
    }
    judge(got, late, transaction, tally.exceptions, tally);
    judge(second.receive(), other, transaction, tally.second_exceptions, tally);
    ++tally.tries;
  }

  TemporaryFolder folder_;
  ScriptedDevices devices_{kLines};
  std::optional<Process> gateway_;
};

TEST_F(LateResponses, AreNeverGivenToAnotherRequest) {
  const int tries = tries_or(200);
  start("quarantine = \"500ms\"\n");
  const Tally tally = run(tries);
  EXPECT_EQ(tally.tries, tries);
  EXPECT_EQ(tally.wrong, 0);
  EXPECT_EQ(tally.missing, 0);
  EXPECT_EQ(tally.second_exceptions, 0);
}

// What the kernel had before the next request was transmitted is no answer to that; what came in
// the same instant, no gateway can tell.
TEST_F(LateResponses, ThatLieInTheLineAreNoAnswerToTheNextRequest) {
  const int tries = tries_or(48);
  for (const char* wake_early : {"0ms", "100us", "1ms"}) {
    start("quarantine = \"100ms\"\nquarantine_max = \"100ms\"\noffline_after = 0\n",
          std::string("[gateway]\nwake_early = \"") + wake_early + "\"\n");
    const Tally tally = run(tries, Aim::end_of_quarantine);
    std::printf("wake_early %s: %d lay there 1 ms before, %d came too close to tell\n", wake_early,
                tally.lay_there, tally.unavoidable);
    EXPECT_EQ(tally.tries, tries);
    EXPECT_EQ(tally.wrong, 0) << wake_early;
    EXPECT_EQ(tally.missing, 0) << wake_early;
  }
}

// Without what is tested, the test sees it.
TEST_F(LateResponses, AreGivenToAnotherRequestWithoutAQuarantine) {
  start("quarantine = \"0s\"\nquarantine_max = \"0s\"\noffline_after = 0\n");
  const Tally tally = run(80);
  EXPECT_GT(tally.wrong, 0);
}

}  // namespace
}  // namespace mbgate::test
