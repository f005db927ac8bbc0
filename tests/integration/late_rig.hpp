// SPDX-License-Identifier: Apache-2.0
// A gateway with lines on which a device answers late, and what two clients of each get.
// MBGATE_LATE_TRIES says how often they ask.
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <cstdlib>
#include <functional>
#include <map>

#include "integration/plant.hpp"
#include "integration/scripted_devices.hpp"

namespace mbgate::test {

using namespace std::chrono_literals;

constexpr int kLateLines = 8;  ///< the first half without retries, the other half with one
constexpr auto kResponseTimeout = 100ms;

inline std::string hex16(unsigned value) {
  char text[8];
  std::snprintf(text, sizeof text, "%04X", value);
  return text;
}

struct Tally {
  int tries = 0;
  int right = 0;
  int exceptions = 0;  ///< of the first client; the second one's are counted apart
  int second_exceptions = 0;
  int wrong = 0;
  int too_late = 0;  ///< answers to earlier requests, but later than the quarantine promises
  int missing = 0;
  void add(const Tally& other) {
    tries += other.tries;
    right += other.right;
    exceptions += other.exceptions;
    second_exceptions += other.second_exceptions;
    wrong += other.wrong;
    too_late += other.too_late;
    missing += other.missing;
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

struct Expected {
  const Question& asked;
  unsigned transaction;
};

class LateRig : public testing::Test {
 protected:
  /// What is done on a line with its two clients.
  using Attempt =
      std::function<void(int line, int number, TcpClient& first, TcpClient& second, Tally& tally)>;

  static int tries_or(int usual) {
    const char* const wanted = std::getenv("MBGATE_LATE_TRIES");
    return wanted == nullptr ? usual : std::atoi(wanted);
  }
  static std::string name_of(int line) { return "line-" + std::to_string(line); }
  static int retries_of(int line) { return line < kLateLines / 2 ? 0 : 1; }
  void ask(int line, TcpClient& client, const Question& question, unsigned transaction) {
    asked_[static_cast<std::size_t>(line)][question.address] = ScriptedDevices::Clock::now();
    client.send(question.adu(transaction));
  }
  /// What another request of the line was answered with is wrong if it came within the quarantine
  /// of that. The gateway's clock for that started later than ours and it took the answer before
  /// we saw it, so this is wrong on a busy machine too; what came later is counted apart.
  void judge(int line, const std::optional<ByteString>& got, const Expected& expected,
             int& exceptions, Tally& tally);
  /// It got another one's answer and nobody could tell: where its own one goes, nobody can either.
  void forget(int line, const Question& question) {
    asked_[static_cast<std::size_t>(line)][question.address] = {};
  }

  /// The quarantine is what judge() holds the gateway to.
  void start(std::chrono::milliseconds quarantine, const std::string& bus,
             const std::string& gateway = "", const std::vector<std::string>& arguments = {});
  /// Shares the tries among the lines, which work side by side.
  Tally run(int tries, const Attempt& attempt);

  TemporaryFolder folder_;
  ScriptedDevices devices_{kLateLines};
  std::optional<Process> gateway_;

 private:
  using Asked = std::map<unsigned, ScriptedDevices::Clock::time_point>;  ///< by address, the last
  [[nodiscard]] bool is_promised(int line, const ByteString& got) const;

  std::chrono::milliseconds quarantine_{0};
  std::array<Asked, kLateLines> asked_;  ///< each line has a thread of its own
};

}  // namespace mbgate::test
