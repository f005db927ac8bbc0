// SPDX-License-Identifier: Apache-2.0
// An adapter that keeps what it is given, and sends it when it goes on.
#include <gmock/gmock.h>

#include "support/machine_rig.hpp"

namespace mbgate::test::stalled_adapter_test {
namespace {

using testing::Each;
using testing::HasSubstr;
using testing::SizeIs;

constexpr int kWrites = 4;

/// Its driver says how much it holds, or says always that it holds nothing. No device answers.
class StallingAdapter {
 public:
  explicit StallingAdapter(bool tells) : tells_(tells) {
    drain();
    feed(gateway::LineOpened{BusId{0}});
    feed(gateway::ClientConnected{ClientId{1},
                                  {ListenerId{0}, *routing::ClientAddress::parse("192.0.2.1")}});
    advance(5ms);
  }
  void write(unsigned number) {
    feed(gateway::ClientBytes{ClientId{1}, unhex(write_request(number))});
  }
  void go_on() {
    late = held_.size();
    held_.clear();
  }
  void advance(Duration duration) {
    const Instant end = harness_.now() + duration;
    for (auto next = harness_.next_wake(); next && next->at <= end; next = harness_.next_wake()) {
      harness_.go_on(std::max(harness_.now(), next->at));
      tell_unsent();
      feed(gateway::DeadlineReached{});
    }
    harness_.go_on(end);
  }

  std::vector<std::string> answers;
  std::vector<std::string> events;
  std::size_t late = 0;  ///< frames that left when it went on

  void take(const gateway::Send& action) {
    answers.push_back(hex({action.adu.data(), action.adu.size()}));
    harness_.handle(gateway::ClientSent{action.client});
  }
  void take(const gateway::Look& action) {
    tell_unsent();
    harness_.handle(gateway::LineLooked{action.bus});
  }
  void take(const gateway::Transmit& action) { held_.push_back(action.frame); }
  void take(const gateway::Shut& /*action*/) {
    held_.clear();  // TCOFLUSH
    reported_ = 0;
  }
  void take(const gateway::Open& action) { harness_.handle(gateway::LineOpened{action.bus}); }
  void take(const gateway::Report& action) {
    events.push_back(report::to_text(action.event, harness_.settings()));
  }
  template <typename Other>
  void take(const Other& /*action*/) {}

 private:
  void tell_unsent() {
    std::size_t bytes = 0;
    for (const auto& frame : held_) {
      bytes += tells_ ? frame.size() : 0;
    }
    if (std::exchange(reported_, bytes) != bytes) {
      harness_.handle(gateway::LineUnsent{BusId{0}, bytes});
    }
  }
  void feed(const gateway::Input& input) {
    harness_.handle(input);
    drain();
  }
  void drain() { harness_.drain(*this); }

  bool tells_;
  GatewayHarness harness_{one_bus(), Instant{}};
  std::vector<bus::FrameBytes> held_;
  std::size_t reported_ = 0;
};

void write_all(StallingAdapter& adapter) {
  for (unsigned number = 1; number <= kWrites; ++number) {
    adapter.write(number);
    adapter.advance(2s);
  }
  EXPECT_THAT(adapter.answers, SizeIs(kWrites));
  EXPECT_THAT(adapter.answers, Each(HasSubstr("86 0B")));
}

TEST(StalledAdapter, SendsNothingLaterIfItsDriverTells) {
  StallingAdapter adapter(true);
  write_all(adapter);
  adapter.go_on();
  EXPECT_EQ(adapter.late, 0U);
  EXPECT_THAT(adapter.events, testing::Contains(HasSubstr("the adapter does not send")));
}

// As before: nothing else is known.
TEST(StalledAdapter, IsNotNoticedIfItsDriverSaysThatItHoldsNothing) {
  StallingAdapter adapter(false);
  write_all(adapter);
  adapter.go_on();
  EXPECT_EQ(adapter.late, std::size_t{kWrites});
  EXPECT_THAT(adapter.events, testing::Not(testing::Contains(HasSubstr("does not send"))));
}

}  // namespace
}  // namespace mbgate::test::stalled_adapter_test
