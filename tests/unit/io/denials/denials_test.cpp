// SPDX-License-Identifier: Apache-2.0
#include "io/denials/denials.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/socket.h>

#include <cerrno>

namespace mbgate::io {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::StartsWith;

/// A system that answers so.
Attempts answering(int v4, int v6, int bind = 0, int folder = 0) {
  return {
      [=](int family) { return family == AF_INET ? v4 : v6; },
      [=](const gateway::ListenerSettings& listener) { return listener.port < 1024 ? bind : 0; },
      [=](const std::string&) { return folder; }};
}

gateway::Settings settings_at(std::uint16_t port) {
  gateway::Settings settings;
  auto& listener = settings.listeners.emplace_back();
  listener.name = "plant";
  listener.address = "0.0.0.0";
  listener.port = port;
  return settings;
}

void add_server(gateway::Settings& settings, const std::string& name, const std::string& host) {
  auto& bus = settings.buses.emplace_back();
  bus.name = name;
  bus.line.framing = bus::Framing::tcp;
  bus.line.remote = bus::Endpoint{host, 502};
}

TEST(Denials, AreNoneWhereEverythingIsPermitted) {
  auto settings = settings_at(502);
  settings.http.listen = {*routing::ListenAddress::parse("[::1]:80")};
  settings.control_socket = "/srv/control";
  add_server(settings, "axes", "drive.plant");
  EXPECT_THAT(denials(settings, {}, answering(0, 0), Starter::systemd), IsEmpty());
}

TEST(Denials, NameTheListenerOfALowPort) {
  EXPECT_THAT(denials(settings_at(502), {}, answering(0, 0, EACCES), Starter::somebody),
              ElementsAre("listener \"plant\": port = 502: cannot listen on 0.0.0.0:502: "
                          "Permission denied; a port below 1024 needs the capability "
                          "CAP_NET_BIND_SERVICE, one from 1024 on needs none"));
}

TEST(Denials, GiveTheSocketUnitToOneListener) {
  auto settings = settings_at(502);
  settings.listeners.push_back(settings.listeners.front());
  settings.listeners.back().name = "plc";
  settings.listeners.back().port = 503;
  const auto attempts = answering(0, 0, EACCES);
  const auto copied = HasSubstr("copy /lib/systemd/system/mbgated.socket to ");
  EXPECT_THAT(denials(settings, {}, attempts, Starter::systemd),
              ElementsAre(HasSubstr("\"systemctl enable mbgated.socket\""), copied));
  EXPECT_THAT(denials(settings, {"plant"}, attempts, Starter::systemd), ElementsAre(copied));
}

TEST(Denials, AreNoneForAPortThatSomebodyHasNow) {
  EXPECT_THAT(denials(settings_at(502), {}, answering(0, 0, EADDRINUSE), Starter::systemd),
              IsEmpty());
}

TEST(Denials, AreNoneForASocketFromSystemd) {
  auto settings = settings_at(502);
  settings.http.listen = {*routing::ListenAddress::parse("127.0.0.1:80")};
  const auto attempts = answering(EAFNOSUPPORT, EAFNOSUPPORT, EACCES);
  EXPECT_THAT(denials(settings, {"plant", "http"}, attempts, Starter::systemd), IsEmpty());
  EXPECT_THAT(denials(settings, {"plant"}, attempts, Starter::systemd),
              ElementsAre(StartsWith("[http] listen: cannot listen on 127.0.0.1:80: Address family "
                                     "not supported by protocol; the service may make no")));
}

// A listener of this name takes the socket from the HTTP interface.
TEST(Denials, KnowWhoseTheSocketNamedHttpIs) {
  auto settings = settings_at(502);
  settings.listeners.front().name = "http";
  settings.http.listen = {*routing::ListenAddress::parse("127.0.0.1:80")};
  EXPECT_THAT(denials(settings, {"http"}, answering(0, 0, EACCES), Starter::systemd),
              ElementsAre(StartsWith("[http] listen: cannot listen on 127.0.0.1:80: ")));
}

TEST(Denials, NameEachBusThatNeedsANetwork) {
  auto settings = settings_at(1502);
  add_server(settings, "axes", "drive.plant");
  add_server(settings, "lift", "10.0.0.5");
  settings.buses.back().line.framing = bus::Framing::rtu;
  settings.buses.back().line.device = "tcp://10.0.0.5:4001";
  settings.buses.emplace_back().line.device = "/dev/ttyS0";
  const std::string why =
      "Address family not supported by protocol; the service may make no network sockets "
      "(RestrictAddressFamilies=, as in the drop-in socket-only.conf): remove "
      "/etc/systemd/system/mbgated.service.d/socket-only.conf, then run \"systemctl "
      "daemon-reload\" and \"systemctl restart mbgated\"";
  EXPECT_THAT(denials(settings, {"plant"}, answering(EAFNOSUPPORT, EAFNOSUPPORT), Starter::systemd),
              ElementsAre("bus \"axes\": host = \"drive.plant\": " + why,
                          "bus \"lift\": device = \"tcp://10.0.0.5:4001\": " + why));
}

TEST(Denials, AreForTheFamilyThatIsNeeded) {
  auto settings = settings_at(1502);
  add_server(settings, "name", "drive.plant");
  add_server(settings, "v4", "10.0.0.5");
  add_server(settings, "v6", "fd00::5");
  EXPECT_THAT(denials(settings, {}, answering(0, EAFNOSUPPORT), Starter::somebody),
              ElementsAre("bus \"v6\": host = \"fd00::5\": Address family not supported by "
                          "protocol; has this machine no IPv6?"));
}

TEST(Denials, AreNoneWhereDescriptorsAreShort) {
  auto settings = settings_at(1502);
  add_server(settings, "axes", "10.0.0.5");
  EXPECT_THAT(denials(settings, {}, answering(EMFILE, EMFILE), Starter::systemd), IsEmpty());
}

TEST(Denials, NameAControlSocketThatCannotBeMade) {
  auto settings = settings_at(1502);
  const auto read_only = answering(0, 0, 0, EROFS);
  EXPECT_THAT(denials(settings, {}, read_only, Starter::systemd), IsEmpty());  // the default path
  settings.control_socket = "/srv/plant/control";
  EXPECT_THAT(denials(settings, {}, read_only, Starter::systemd),
              ElementsAre("[http] socket = \"/srv/plant/control\": Read-only file system; the "
                          "service may not write there: choose a path below /run/mbgate; or run "
                          "\"systemctl edit mbgated\", paste the two lines \"[Service]\" and "
                          "\"ReadWritePaths=/srv/plant\", then run \"systemctl restart mbgated\""));
  EXPECT_THAT(denials(settings, {}, answering(0, 0, 0, ENOENT), Starter::systemd), IsEmpty());
}

}  // namespace
}  // namespace mbgate::io
