// SPDX-License-Identifier: Apache-2.0
#include "app/http_listeners.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <string>
#include <utility>
#include <vector>

#include "io/clients/listening_socket.hpp"
#include "unit/io/run_until.hpp"

namespace mbgate::app {
namespace {

using testing::ElementsAre;

gateway::HttpSettings listen_at(const std::vector<std::string>& addresses) {
  gateway::HttpSettings settings;
  for (const auto& address : addresses) {
    settings.listen.push_back(*routing::ListenAddress::parse(address));
  }
  return settings;
}

std::vector<std::string> texts(const std::vector<gateway::ListenerSettings>& listeners) {
  std::vector<std::string> found;
  found.reserve(listeners.size());
  for (const auto& it : listeners) {
    found.push_back(it.name + ' ' + it.address + ' ' + std::to_string(it.port) +
                    (it.is_gone ? " gone" : ""));
  }
  return found;
}

TEST(HttpListeners, AreThoseOfTheSettings) {
  const auto listeners = http_listeners({}, listen_at({"127.0.0.1:8080", "[::1]:0"}));
  EXPECT_THAT(texts(listeners), ElementsAre("http 127.0.0.1 8080", "http ::1 0"));
}

TEST(HttpListeners, KeepTheirNumbersWhileOthersComeAndGo) {
  auto listeners = http_listeners({}, listen_at({"127.0.0.1:8080", "127.0.0.1:8081"}));
  listeners = http_listeners(listeners, listen_at({"127.0.0.1:8082", "127.0.0.1:8081"}));
  EXPECT_THAT(texts(listeners), ElementsAre("http 127.0.0.1 8080 gone", "http 127.0.0.1 8081",
                                            "http 127.0.0.1 8082"));
  listeners = http_listeners(listeners, listen_at({"127.0.0.1:8080"}));
  EXPECT_THAT(texts(listeners), ElementsAre("http 127.0.0.1 8080", "http 127.0.0.1 8081 gone",
                                            "http 127.0.0.1 8082 gone"));
}

TEST(HttpListeners, OfWhichTheKernelChoosesThePortsAreSeveral) {
  auto listeners = http_listeners({}, listen_at({"127.0.0.1:0", "127.0.0.1:0"}));
  listeners = http_listeners(listeners, listen_at({"127.0.0.1:0"}));
  EXPECT_THAT(texts(listeners), ElementsAre("http 127.0.0.1 0", "http 127.0.0.1 0 gone"));
}

/// A gateway of which nothing is asked.
class UnaskedTarget final : public ControlTarget {
  gateway::StatusReport report_status(bool /*with_clients*/) const override { return {}; }
  ProcessStatus process_status() const override { return {}; }
  [[nodiscard]] bool meets_deadlines() const override { return true; }
  void reload(const Asker& /*asker*/, ReloadEnded /*ended*/) override {}
  void command_denied(const Asker& /*asker*/, const std::string& /*what*/) override {}
  void clear_counters(const Asker& /*asker*/) override {}
  void set_traced(bool /*traced*/) override {}
  gateway::TraceBook::Taken take_trace() override { return {}; }
  void control_failed(const std::string& /*why*/) override {}
  void http_refused(const std::string& /*address*/) override {}
};

class HttpListenersReload : public testing::Test {
 protected:
  HttpListenersReload() {
    log_.observe([this](Level, const std::string& text) { said_.push_back(text); });
  }
  void begin(const std::vector<std::string>& addresses) {
    http_.begin(listen_at(addresses));
    http_.start();
  }
  /// Until the addresses are free that `next` does not have.
  testing::AssertionResult make_room(const std::vector<std::string>& next) {
    bool is_free = false;
    http_.make_room(listen_at(next), [&] { is_free = true; });
    return io::run_until(context_, [&] { return is_free; }) ? testing::AssertionSuccess()
                                                            : testing::AssertionFailure();
  }
  /// An address of this machine where nobody listens.
  std::string free_address() {
    const boost::asio::ip::tcp::acceptor chosen(context_,
                                                {boost::asio::ip::address_v4::loopback(), 0});
    return io::to_text(chosen.local_endpoint());
  }
  /// Can another kind of listener have it?
  bool can_be_had(const std::string& address) {
    auto other = http_listeners({}, listen_at({address})).front();
    return static_cast<bool>(io::bind_listener(context_, other));
  }

  boost::asio::io_context context_;
  UnaskedTarget target_;
  Log log_{false};
  std::vector<std::string> said_;
  Control control_{context_, target_};
  HttpListeners http_{context_, log_, control_};
};

TEST_F(HttpListenersReload, MakesRoomBeforeOthersBind) {
  const std::string address = free_address();
  begin({address});
  ASSERT_FALSE(can_be_had(address));
  ASSERT_TRUE(make_room({"127.0.0.1:0"}));
  EXPECT_TRUE(can_be_had(address));
  http_.reload(listen_at({"127.0.0.1:0"}));
  EXPECT_TRUE(can_be_had(address));
  EXPECT_EQ(said_.size(), 2U);
  EXPECT_THAT(said_, testing::Each(testing::StartsWith("listening http 127.0.0.1:")));
}

TEST_F(HttpListenersReload, TakesItsAddressBackIfTheOthersCannotBeHad) {
  const std::string address = free_address();
  begin({address});
  ASSERT_TRUE(make_room({}));
  http_.reload(listen_at({address}));
  EXPECT_FALSE(can_be_had(address));
  EXPECT_THAT(said_, ElementsAre("listening http " + address, "listening http " + address));
}

TEST_F(HttpListenersReload, LeavesNoAddressThatNobodyCanAskFor) {
  begin({"127.0.0.1:0"});
  bool is_free = false;
  http_.make_room(listen_at({}), [&] { is_free = true; });
  EXPECT_TRUE(is_free);  // at once: there was nothing to be closed
  http_.reload(listen_at({"127.0.0.1:0"}));
  EXPECT_EQ(said_.size(), 1U);
}

}  // namespace
}  // namespace mbgate::app
