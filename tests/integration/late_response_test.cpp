// SPDX-License-Identifier: Apache-2.0
// Late responses over real ptys: a device answers its first client up to 300 ms after the response
// timeout, while a second client asks for other registers of it, as many and by the same function,
// so that nothing in the frames tells the answers apart.
#include "integration/late_rig.hpp"

namespace mbgate::test::late_response_test {
namespace {

constexpr int kLongestLateness = 300;

class LateResponses : public LateRig {
 protected:
  Tally run(int tries) {
    return LateRig::run(tries, [this](auto&&... with) { attempt(with...); });
  }

 private:
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
    const int round = number / kLateLines;
    const auto lateness = std::chrono::milliseconds(1 + number * 7 % kLongestLateness);
    const unsigned count = 1 + static_cast<unsigned>(round) % 4;
    const Question late{static_cast<unsigned>(number % 1000) * 10, count};
    const Question other{late.address + 20'000, count};
    const auto transaction = static_cast<unsigned>(number) & 0xFFFFU;
    auto answers = delays(retries_of(line) == 0 ? 0 : round, kResponseTimeout + lateness);
    answers.resize(static_cast<std::size_t>(retries_of(line)) + 1);
    devices_.plan(line, late.address, std::move(answers));
    ask(line, first, late, transaction);
    // The other client comes while the first one waits, or when that has its answer.
    std::optional<ByteString> got;
    if (round / 2 % 2 == 0) {
      got = first.receive(number * 11 % 95);
    } else {
      got = first.receive();
    }
    ask(line, second, other, transaction);
    if (!got) {
      got = first.receive();
    }
    judge(line, got, {late, transaction}, tally.exceptions, tally);
    // A busy machine's device may be late with this one too; it is asked again then.
    for (const int right = tally.right; tally.right == right && tally.missing == 0;) {
      const int exceptions = tally.second_exceptions;
      judge(line, second.receive(), {other, transaction}, tally.second_exceptions, tally);
      if (tally.second_exceptions == exceptions) {
        return;
      }
      second.send(other.adu(transaction));
    }
  }
};

TEST_F(LateResponses, AreNeverGivenToAnotherRequest) {
  const int tries = tries_or(200);
  start(500ms, "quarantine = \"500ms\"\n");
  const Tally tally = run(tries);
  EXPECT_EQ(tally.tries, tries);
  EXPECT_EQ(tally.wrong, 0);
  EXPECT_EQ(tally.missing, 0);
}

// Without what is tested, the test sees it.
TEST_F(LateResponses, AreGivenToAnotherRequestWithoutAQuarantine) {
  start(500ms, "quarantine = \"0s\"\nquarantine_max = \"0s\"\noffline_after = 0\n");
  int wrong = 0;
  for (int times = 0; wrong == 0 && times < 20; ++times) {
    wrong = run(80).wrong;
  }
  EXPECT_GT(wrong, 0);
}

}  // namespace
}  // namespace mbgate::test::late_response_test
