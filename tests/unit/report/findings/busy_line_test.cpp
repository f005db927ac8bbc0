// SPDX-License-Identifier: Apache-2.0
// Lines that are asked for more than they can carry, and who does that.
#include "unit/report/findings/trouble.hpp"

namespace mbgate::test {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::StartsWith;

/// Clients whose requests are answered 90 ms later, and who ask again at once.
class Crowd : public Trouble {
 public:
  explicit Crowd(const Settings& settings = troubled_plant()) : Trouble(settings) {
    clients_ = {{1, "192.0.2.7"}};
  }
  void add(std::uint64_t client, std::string_view address, unsigned unit, int requests) {
    if (clients_.emplace(client, address).second) {
      rig.connect(client, address);
    }
    client_of_[unit] = client;
    for (int at = 0; at < requests; ++at) {
      rig.receive(client, read_request(1, unit));
    }
  }
  /// What is answered is not asked for again.
  void calm_down(int transactions) {
    asks_again_ = false;
    go_on(transactions);
    asks_again_ = true;
  }
  /// The device at this address says nothing.
  void silence(unsigned unit) { silent_ = unit; }
  void go_on(int transactions) {
    for (int at = 0; at < transactions; ++at) {
      rig.advance(90ms);
      const Lines sent = rig.take_transmitted();
      if (sent.empty()) {
        continue;
      }
      const auto unit = static_cast<unsigned>(std::stoul(sent.back().substr(0, 2), nullptr, 16));
      if (unit == silent_) {
        rig.advance(20ms);
      } else {
        rig.respond("0" + std::to_string(unit) + " 03 02 12 34");
      }
      if (asks_again_) {
        rig.receive(client_of_[unit], read_request(1, unit));
      }
    }
  }

 private:
  std::map<std::uint64_t, std::string> clients_;
  std::map<unsigned, std::uint64_t> client_of_;
  bool asks_again_ = true;
  unsigned silent_ = 0;
};

constexpr int kLongTime = 250;  // transactions: more than two windows of the load

TEST(BusyLine, NamesTheClientThatAsksForMostOfWhatWaits) {
  Crowd crowd;
  crowd.add(1, "192.0.2.7", 1, 20);
  crowd.add(2, "192.0.2.8", 2, 2);
  crowd.go_on(kLongTime);
  EXPECT_THAT(
      crowd.diagnoses(),
      ElementsAre(AllOf(StartsWith("client 192.0.2.7: it asks for more than bus line-a can carry | "
                                   "bus line-a is busy "),
                        HasSubstr(" of the 22 requests that wait are from it, the oldest for "),
                        testing::EndsWith(" ms | how often it asks, and on how many connections; "
                                          "`pipeline`; `cache` for what it reads"))));
  EXPECT_EQ(crowd.diagnoses(false), crowd.diagnoses());  // those who count them see no clients
}

TEST(BusyLine, NamesNobodyWhereAllAskAlike) {
  Crowd crowd;
  crowd.add(1, "192.0.2.7", 1, 20);
  crowd.add(2, "192.0.2.8", 2, 20);
  crowd.go_on(kLongTime);
  EXPECT_THAT(crowd.diagnoses(),
              ElementsAre(StartsWith("bus line-a: it is asked for more than it can carry | ")));
}

TEST(BusyLine, NamesNoClientThatIsAlone) {
  Crowd crowd;
  crowd.add(1, "192.0.2.7", 1, 20);
  crowd.rig.connect(2, "192.0.2.8");  // it asks for nothing
  crowd.go_on(kLongTime);
  EXPECT_THAT(crowd.diagnoses(),
              ElementsAre(StartsWith("bus line-a: it is asked for more than it can carry | ")));
}

TEST(BusyLine, IsTooBusyWhereTwoOfThreeAskForTooMuch) {
  Crowd crowd;
  crowd.add(1, "192.0.2.7", 1, 15);
  crowd.add(2, "192.0.2.8", 2, 15);
  crowd.add(3, "192.0.2.9", 3, 1);
  crowd.go_on(kLongTime);
  EXPECT_THAT(
      crowd.diagnoses(),
      ElementsAre(
          AllOf(StartsWith("bus line-a: it is asked for more than it can carry | busy "),
                HasSubstr(" requests waited 500 ms or longer | poll less often; longer reads "))));
}

TEST(BusyLine, IsTooBusyThoughADriveWasReadWithoutWaiting) {
  Crowd crowd;
  crowd.ask_and_answer(3);
  crowd.add(1, "192.0.2.7", 1, 20);
  crowd.add(2, "192.0.2.8", 2, 20);
  crowd.go_on(kLongTime);
  EXPECT_THAT(crowd.diagnoses(),
              ElementsAre(StartsWith("bus line-a: it is asked for more than it can carry | ")));
}

TEST(BusyLine, IsWellSoonAfterItWasTooBusy) {
  Crowd crowd;
  crowd.add(1, "192.0.2.7", 1, 20);
  crowd.add(2, "192.0.2.8", 2, 20);
  crowd.go_on(kLongTime);
  EXPECT_THAT(crowd.diagnoses(), testing::SizeIs(1));
  crowd.calm_down(36);
  crowd.go_on(kLongTime);
  EXPECT_THAT(crowd.diagnoses(), IsEmpty());
}

// The line is not what these wait for.
TEST(BusyLine, IsNotFloodedByRequestsThatWaitForTheirDevice) {
  Settings settings = troubled_plant();
  settings.devices[0].timing.quarantine = 1h;
  settings.devices[0].timing.quarantine_max = 1h;
  settings.routes[0].deadline = 1h;
  Crowd crowd(settings);
  crowd.silence(1);
  crowd.add(1, "192.0.2.7", 1, 20);
  crowd.go_on(2);
  crowd.add(2, "192.0.2.8", 2, 1);
  crowd.go_on(kLongTime);
  EXPECT_THAT(crowd.diagnoses(), IsEmpty());
}

TEST(BusyLine, IsWellWhereNobodyWaitsLong) {
  Crowd crowd;
  crowd.add(1, "192.0.2.7", 1, 2);
  crowd.add(2, "192.0.2.8", 2, 2);
  crowd.go_on(kLongTime);
  EXPECT_THAT(crowd.diagnoses(), IsEmpty());
}

// What waits for its timeouts is not asked for too often.
TEST(BusyLine, IsNotToldWhereADriveLetsRequestsTimeOut) {
  Crowd crowd;
  crowd.add(1, "192.0.2.7", 1, 20);
  crowd.add(2, "192.0.2.8", 2, 20);
  crowd.silence(1);
  crowd.go_on(kLongTime);
  EXPECT_THAT(crowd.diagnoses(), ElementsAre(StartsWith("device axis: it has never answered | ")));
}

}  // namespace
}  // namespace mbgate::test
