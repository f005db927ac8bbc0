// SPDX-License-Identifier: Apache-2.0
#include "app/http_listeners.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

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

}  // namespace
}  // namespace mbgate::app
