// SPDX-License-Identifier: Apache-2.0
// Lines that are asked for more than they can carry, and who does that.
#include "unit/gateway/status/trouble.hpp"

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
  using Trouble::Trouble;
  void add(std::uint64_t client, std::string_view address, unsigned unit, int requests) {
    if (client != 1) {
      rig.connect(client, address);
    }
    client_of_[unit] = client;
    for (int at = 0; at < requests; ++at) {
      rig.receive(client, read_request(1, unit));
    }
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
      const unsigned unit = sent.back().starts_with("01") ? 1 : 2;
      if (unit == silent_) {
        rig.advance(20ms);
      } else {
        rig.respond(unit == 1 ? kAnswerOfAxis : "02 03 02 12 34");
      }
      rig.receive(client_of_[unit], read_request(1, unit));
    }
  }

 private:
  std::map<unsigned, std::uint64_t> client_of_;
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
                        HasSubstr(" requests that wait are its, the oldest for "),
                        testing::EndsWith(" ms | how often it asks, and on how many connections; "
                                          "`pipeline`; `cache`, `merge` for what it reads"))));
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
