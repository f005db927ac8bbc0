// SPDX-License-Identifier: Apache-2.0
#include "io/denials/advice.hpp"

#include <gtest/gtest.h>

#include <cerrno>
#include <sstream>

namespace mbgate::io {
namespace {

gateway::ListenerSettings listener_at(const std::string& name, const std::string& address,
                                      std::uint16_t port) {
  gateway::ListenerSettings listener;
  listener.name = name;
  listener.address = address;
  listener.port = port;
  return listener;
}

constexpr const char* kOrDropIn =
    "; or copy /usr/share/doc/mbgate/examples/port-502.conf to "
    "/etc/systemd/system/mbgated.service.d/, then run \"systemctl daemon-reload\" and \"systemctl "
    "restart mbgated\"";

TEST(PortAdvice, IsTheSocketUnitAsItIsForTheListenerThatItIsMadeFor) {
  EXPECT_EQ(
      port_advice(listener_at("plant", "0.0.0.0", 502), EACCES, SocketUnit::free, Starter::systemd),
      std::string("; the service may open no port below 1024: let systemd open it: run "
                  "\"systemctl stop mbgated\", \"systemctl enable mbgated.socket\", "
                  "\"systemctl start mbgated\"") +
          kOrDropIn);
}

TEST(PortAdvice, HasTheLinesThatMakeTheSocketUnitOneForAnotherListener) {
  EXPECT_EQ(port_advice(listener_at("plc", "2001:db8::5", 802), EACCES, SocketUnit::free,
                        Starter::systemd),
            std::string("; the service may open no port below 1024: let systemd open it: run "
                        "\"systemctl stop mbgated\", \"systemctl edit mbgated.socket\" with the "
                        "lines \"[Socket]\", \"FileDescriptorName=plc\", \"ListenStream=\", "
                        "\"ListenStream=[2001:db8::5]:802\", \"systemctl enable mbgated.socket\", "
                        "\"systemctl start mbgated\"") +
                kOrDropIn);
}

TEST(PortAdvice, IsACopyOfTheSocketUnitWhereAnotherListenerHasIt) {
  EXPECT_EQ(
      port_advice(listener_at("plc", "10.0.0.2", 503), EACCES, SocketUnit::taken, Starter::systemd),
      std::string("; the service may open no port below 1024: let systemd open it: copy "
                  "/lib/systemd/system/mbgated.socket to /etc/systemd/system/mbgated-plc.socket, "
                  "with the lines \"Service=mbgated.service\", \"FileDescriptorName=plc\", "
                  "\"ListenStream=\", \"ListenStream=10.0.0.2:503\" in its section [Socket], and "
                  "run \"systemctl "
                  "stop mbgated\", \"systemctl enable mbgated-plc.socket\", \"systemctl start "
                  "mbgated\"") +
          kOrDropIn);
}

TEST(PortAdvice, IsTheSocketUnitOfHttpForHttp) {
  EXPECT_EQ(
      port_advice(listener_at("http", "127.0.0.1", 80), EACCES, SocketUnit::free, Starter::systemd),
      std::string("; the service may open no port below 1024: let systemd open it: run "
                  "\"systemctl stop mbgated\", \"systemctl edit mbgated-http.socket\" with "
                  "the lines \"[Socket]\", \"ListenStream=\", \"ListenStream=127.0.0.1:80\", "
                  "\"systemctl enable mbgated-http.socket\", \"systemctl start mbgated\"") +
          kOrDropIn);
}

TEST(PortAdvice, IsTheCapabilityOrAnotherPortForOthers) {
  EXPECT_EQ(port_advice(listener_at("plant", "0.0.0.0", 502), EACCES, SocketUnit::free,
                        Starter::somebody),
            "; a port below 1024 needs the capability CAP_NET_BIND_SERVICE, one from 1024 on needs "
            "none");
}

TEST(PortAdvice, NamesNoDropInWhereAnotherRuleForbidsThePort) {
  const auto listener = listener_at("plant", "0.0.0.0", 1502);
  EXPECT_EQ(port_advice(listener, EACCES, SocketUnit::free, Starter::systemd),
            "; SocketBindDeny= of the unit or a security module forbids this port");
  EXPECT_EQ(
      port_advice(listener_at("plant", "0.0.0.0", 502), EPERM, SocketUnit::free, Starter::somebody),
      "; a security module forbids this port");
}

constexpr const char* kWithout =
    "remove /etc/systemd/system/mbgated.service.d/socket-only.conf, then run \"systemctl "
    "daemon-reload\" and \"systemctl restart mbgated\"";

TEST(FamilyAdvice, NamesTheDropInThatTakesTheNetworkAway) {
  const FamilyErrors errors{EAFNOSUPPORT, EAFNOSUPPORT};
  const std::string cause =
      "; the service may make no network sockets (RestrictAddressFamilies=, as in the drop-in "
      "socket-only.conf): ";
  EXPECT_EQ(connect_advice(errors, Starter::systemd), cause + kWithout);
  EXPECT_EQ(
      listen_advice(listener_at("plant", "::", 502), errors, SocketUnit::free, Starter::systemd),
      cause +
          "let systemd open it: run \"systemctl stop mbgated\", \"systemctl enable "
          "mbgated.socket\", \"systemctl start mbgated\"; or " +
          kWithout);
}

TEST(FamilyAdvice, DoesNotSayWhichOfTwoCausesItIs) {
  const FamilyErrors v6_alone{EAFNOSUPPORT, 0};
  EXPECT_EQ(connect_advice(v6_alone, Starter::systemd),
            "; this machine has no IPv6, or RestrictAddressFamilies= of the unit lacks AF_INET6");
  EXPECT_EQ(connect_advice(v6_alone, Starter::somebody), "; has this machine no IPv6?");
  const std::string filter =
      "; this process may make no network sockets: a filter of system calls or a security module "
      "forbids it";
  EXPECT_EQ(connect_advice({EPERM, EPERM}, Starter::systemd), filter);
  EXPECT_EQ(connect_advice({EAFNOSUPPORT, EAFNOSUPPORT}, Starter::somebody), filter);
}

TEST(FolderAdvice, SaysWhereTheServiceMayWrite) {
  EXPECT_EQ(folder_advice("/srv/plant", EROFS, "choose a path below /run/mbgate", Starter::systemd),
            "; the service may not write there: choose a path below /run/mbgate; or run "
            "\"systemctl edit mbgated\", paste the two lines \"[Service]\" and "
            "\"ReadWritePaths=/srv/plant\", then run \"systemctl restart mbgated\"");
  EXPECT_EQ(folder_advice("/srv/plant", EROFS, "unused", Starter::somebody), "");
  EXPECT_EQ(folder_advice("/srv/plant", EACCES, "unused", Starter::systemd),
            "; the service may not write there: unused; or let the user mbgate write into "
            "/srv/plant");
  EXPECT_EQ(folder_advice("/srv/plant", EACCES, "unused", Starter::somebody),
            "; the user that mbgated runs as may not write into /srv/plant");
  EXPECT_EQ(folder_advice("/srv/plant", ENOENT, "unused", Starter::systemd), "");
}

TEST(LockAdvice, NamesTheDropIn) {
  EXPECT_EQ(lock_advice(Starter::systemd),
            "; the unit needs LimitMEMLOCK=infinity: copy "
            "/usr/share/doc/mbgate/examples/realtime.conf to "
            "/etc/systemd/system/mbgated.service.d/, then run \"systemctl daemon-reload\" and "
            "\"systemctl restart mbgated\"");
  EXPECT_EQ(lock_advice(Starter::somebody),
            "; the limit of locked memory must be unlimited (\"ulimit -l unlimited\")");
}

TEST(TtyAdvice, NamesTheGroupThatTheFileHas) {
  const TtyAccess access{0660, "uucp", false};
  EXPECT_EQ(tty_advice("/dev/ttyS0", access, Starter::somebody),
            "; the user that mbgated runs as must be in the group uucp: run \"sudo adduser NAME "
            "uucp\", then log in again");
  EXPECT_EQ(tty_advice("/dev/ttyS0", access, Starter::systemd),
            "; the user that mbgated runs as must be in the group uucp: run \"systemctl edit "
            "mbgated\", paste the two lines \"[Service]\" and \"SupplementaryGroups=uucp\", then "
            "run \"systemctl restart mbgated\"");
}

// As all groups but its own are to a service with PrivateUsers=yes, whether it is in them or not.
TEST(TtyAdvice, SaysHowToFindAGroupThatIsNotKnownHere) {
  const std::string who =
      "; the user that mbgated runs as must be in the group of this port, mostly dialout (\"ls -lL "
      "/dev/ttyS0\" names it): run ";
  EXPECT_EQ(tty_advice("/dev/ttyS0", {0660, "", true}, Starter::systemd),
            who +
                "\"systemctl edit mbgated\", paste the two lines \"[Service]\" and "
                "\"SupplementaryGroups=GROUP\", then run \"systemctl restart mbgated\"");
  EXPECT_EQ(tty_advice("/dev/ttyS0", {}, Starter::somebody),
            who + "\"sudo adduser NAME GROUP\", then log in again");
}

TEST(TtyAdvice, NamesNoGroupWhereThatWouldNotHelp) {
  const TtyAccess closed{0600, "root", false};
  EXPECT_EQ(tty_advice("/dev/ttyS0", closed, Starter::systemd),
            "; its mode 0600 lets no group use it: a udev rule must give it to the group dialout "
            "with mode 0660");
  const TtyAccess member{0660, "dialout", true};
  EXPECT_EQ(tty_advice("/dev/ttyS0", member, Starter::systemd),
            "; its mode and group allow it: the mount option nodev or a security module forbids "
            "it");
}

TEST(Network, IsMissingWhereThereIsOnlyTheLoopbackInterface) {
  const std::string titles =
      "Inter-|   Receive                                                |  Transmit\n"
      " face |bytes    packets errs drop fifo frame compressed multicast|bytes    packets errs\n";
  const auto is_alone = [&](const std::string& lines) {
    std::istringstream devices(titles + lines);
    return is_loopback_alone(devices);
  };
  EXPECT_TRUE(is_alone("    lo:       0       0    0    0    0     0          0         0\n"));
  EXPECT_FALSE(is_alone("    lo:       0       0    0\n  eth0:       0       0    0\n"));
  EXPECT_FALSE(is_alone("  eth0:       0       0    0\n"));
  std::istringstream unreadable("");
  EXPECT_FALSE(is_loopback_alone(unreadable));
}

}  // namespace
}  // namespace mbgate::io
