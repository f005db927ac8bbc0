// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "config/load.hpp"

namespace mbgate::config {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

gateway::Settings listening_at(std::uint16_t port) {
  gateway::Settings settings;
  auto& listener = settings.listeners.emplace_back();
  listener.name = "plant";
  listener.port = port;
  return settings;
}

TEST(Needs, AreNoneOfAPlainConfiguration) {
  auto settings = listening_at(1502);
  settings.buses.emplace_back().line.device = "/dev/pts/7";
  EXPECT_THAT(needs(settings), IsEmpty());
  EXPECT_THAT(needs(listening_at(0)), IsEmpty());
}

TEST(Needs, NameTheProcessThatHoldsKeys) {
  auto settings = listening_at(1502);
  settings.tls.emplace_back();
  settings.listeners[0].tls = 0;
  EXPECT_THAT(needs(settings), ElementsAre("needs /run/mbgate-signer/socket ([gateway] signer): "
                                           "mbgate-signer.socket"));
}

TEST(Needs, NameUnitsAndDropIns) {
  auto settings = listening_at(502);
  settings.http.listen = {*routing::ListenAddress::parse("127.0.0.1:80"),
                          *routing::ListenAddress::parse("[::1]:9502")};
  for (const auto* device : {"/dev/ttyS0", "/dev/serial/by-id/usb-FTDI"}) {
    settings.buses.emplace_back().line.device = device;
  }
  for (const auto* name : {"axes", "lift"}) {
    auto& bus = settings.buses.emplace_back();
    bus.name = name;
    bus.line.remote = bus::Endpoint{"10.0.0.5", 502};
  }
  settings.lock_memory = true;
  settings.control_socket = "/srv/plant/control";
  EXPECT_THAT(
      needs(settings),
      ElementsAre("needs port 502 (listener \"plant\"): mbgated.socket, for which it needs "
                  "'allow', or the drop-in port-502.conf",
                  "needs 127.0.0.1:80 ([http] listen): mbgated-http.socket, or the drop-in "
                  "port-502.conf",
                  "needs [::1]:9502 ([http] listen): with the drop-in socket-only.conf, "
                  "mbgated-http.socket",
                  "needs the group dialout: /dev/ttyS0, /dev/serial/by-id/usb-FTDI",
                  "needs a network (bus \"axes\", \"lift\"): not with the drop-in socket-only.conf",
                  "needs lock_memory: the drop-in realtime.conf",
                  "needs [http] socket = \"/srv/plant/control\": ReadWritePaths= of its folder in "
                  "a drop-in, or a path below /run/mbgate"));
}

}  // namespace
}  // namespace mbgate::config
