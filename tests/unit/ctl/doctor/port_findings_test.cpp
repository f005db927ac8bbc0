// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cerrno>

#include "ctl/doctor/findings.hpp"
#include "printed_finding.hpp"

namespace mbgate::ctl {
namespace {

const std::string kPort = "/dev/ttyUSB0";
const std::string kByItsId = "/dev/serial/by-id/usb-FTDI-if00";

TEST(PortFinding, NamesThePortsThatThereAre) {
  EXPECT_EQ(port_finding(kPort, {.error = ENOENT}),
            (Finding{Judgement::fault, "port", "there is no serial port /dev/ttyUSB0",
                     "is the adapter plugged in? look at dmesg"}));
  EXPECT_EQ(
      port_finding(kPort, {.error = ENOENT, .names = {kByItsId}}),
      (Finding{Judgement::fault, "port",
               "there is no serial port /dev/ttyUSB0; there is " + kByItsId, "name one of these"}));
  EXPECT_EQ(port_finding("/etc/passwd", {}),
            (Finding{Judgement::fault, "port", "/etc/passwd is not a serial port",
                     "name a serial port, such as one in /dev/serial/by-id"}));
}

TEST(PortFinding, SuggestsTheNameThatStays) {
  const Finding plain{Judgement::ok, "port", "/dev/ttyUSB0 exists"};
  EXPECT_EQ(port_finding(kPort, {.is_character_device = true}), plain);
  auto named = plain;
  named.advice =
      "this name may change when adapters are plugged in differently; this one does not: " +
      kByItsId;
  EXPECT_EQ(port_finding(kPort, {.is_character_device = true, .leading = {kByItsId}}), named);
  EXPECT_EQ(port_finding(kByItsId, {.is_character_device = true, .is_lasting = true}),
            (Finding{Judgement::ok, "port", kByItsId + " exists"}));
}

PermissionFacts not_allowed() {
  PermissionFacts facts;
  facts.error = EACCES;
  facts.owner = "root";
  facts.group = "dialout";
  facts.mode = 0660;
  facts.user = "anna";
  return facts;
}

TEST(PermissionFinding, SaysHowToJoinTheGroup) {
  EXPECT_EQ(permission_finding(kPort, not_allowed()),
            (Finding{Judgement::fault, "permission",
                     "anna may not open /dev/ttyUSB0: not a member of group dialout, which owns it",
                     "sudo adduser anna dialout, then log in again"}));
  auto joined = not_allowed();
  joined.becomes_member = true;
  EXPECT_EQ(permission_finding(kPort, joined),
            (Finding{Judgement::fault, "permission",
                     "anna may not open /dev/ttyUSB0: a member of group dialout, but not yet in "
                     "this login session",
                     "log in again"}));
}

TEST(PermissionFinding, DoesNotSendAnybodyIntoAGroupThatMayNot) {
  auto closed = not_allowed();
  closed.mode = 0600;
  EXPECT_EQ(permission_finding(kPort, closed),
            (Finding{Judgement::fault, "permission",
                     "anna may not open /dev/ttyUSB0: its mode is 0600, of root and group dialout",
                     "a udev rule must give it to a group, or run this with sudo"}));
  auto member = not_allowed();
  member.is_member = true;
  EXPECT_EQ(permission_finding(kPort, member),
            (Finding{Judgement::fault, "permission",
                     "anna may not open /dev/ttyUSB0: Permission denied, though a member of group "
                     "dialout",
                     "look for what else forbids it: getfacl /dev/ttyUSB0"}));
  auto allowed = not_allowed();
  allowed.error = 0;
  EXPECT_EQ(permission_finding(kPort, allowed),
            (Finding{Judgement::ok, "permission", "anna may open /dev/ttyUSB0"}));
}

TEST(HolderFinding, NamesWhoHasThePort) {
  EXPECT_EQ(held_finding(kPort, {{12, "mbgated"}}),
            (Finding{Judgement::fault, "holder",
                     "mbgated (process 12) has /dev/ttyUSB0 open, and it is locked",
                     "ask it with mbgatectl status, or stop it: sudo systemctl stop mbgated"}));
  EXPECT_EQ(held_finding(kPort, {{12, "mbpoll"}, {13, "minicom"}}),
            (Finding{Judgement::fault, "holder",
                     "mbpoll (process 12), minicom (process 13) have /dev/ttyUSB0 open, and it is "
                     "locked",
                     "end it first"}));
  EXPECT_EQ(held_finding(kPort, {}),
            (Finding{Judgement::fault, "holder", "a gateway or another program holds /dev/ttyUSB0",
                     "sudo fuser -v /dev/ttyUSB0 names it; stop a gateway with sudo systemctl stop "
                     "mbgated, or ask it with mbgatectl status"}));
}

TEST(HolderFinding, SaysWhoReadsAlongWithoutALock) {
  EXPECT_EQ(free_finding(kPort, {}),
            (Finding{Judgement::ok, "holder", "no other program is seen to have it open"}));
  EXPECT_EQ(free_finding(kPort, {{12, "mbpoll"}}),
            (Finding{Judgement::fault, "holder",
                     "mbpoll (process 12) has /dev/ttyUSB0 open too; nothing was sent, because "
                     "each program would take bytes from the others",
                     "end it first"}));
}

constexpr const char* kHowTo =
    "this line in /etc/udev/rules.d/99-ftdi.rules makes it 1 ms: "
    R"(ACTION=="add", SUBSYSTEM=="usb-serial", DRIVER=="ftdi_sio", ATTR{latency_timer}="1")";

TEST(LatencyFinding, IsAFaultOnlyWhereTheGatewayLeavesItSo) {
  EXPECT_EQ(latency_finding({kPort, 16, false}),
            (Finding{Judgement::fault, "latency",
                     "the adapter hands bytes over after 16 ms, and low_latency = false leaves it "
                     "so",
                     "set low_latency = true; or " + std::string(kHowTo)}));
  const Finding slow{
      Judgement::ok, "latency",
      "the adapter hands bytes over after 16 ms; the times below may be too long by that",
      "mbgated itself asks for 1 ms (low_latency); for other programs " + std::string(kHowTo)};
  EXPECT_EQ(latency_finding({kPort, 16, true}), slow);
  EXPECT_EQ(latency_finding({kPort, 16, std::nullopt}), slow);
  EXPECT_EQ(latency_finding({kPort, 1, false}),
            (Finding{Judgement::ok, "latency", "the adapter hands bytes over after 1 ms"}));
}

TEST(LatencyFinding, KnowsNothingOfOtherAdapters) {
  EXPECT_EQ(latency_finding({"/dev/ttyS0"}),
            (Finding{Judgement::unknown, "latency",
                     "/dev/ttyS0 is not an FTDI adapter, or does not show its timer"}));
}

TEST(AvoidableDelay, IsTheTimerThatAGatewayShortens) {
  using std::chrono::milliseconds;
  EXPECT_EQ(avoidable_delay({"/dev/ttyUSB0", 16U, true}), milliseconds(16));
  EXPECT_EQ(avoidable_delay({"/dev/ttyUSB0", 16U, std::nullopt}), milliseconds(16));
  EXPECT_EQ(avoidable_delay({"/dev/ttyUSB0", 16U, false}), milliseconds(0));
  EXPECT_EQ(avoidable_delay({"/dev/ttyUSB0", 1U, true}), milliseconds(0));
  EXPECT_EQ(avoidable_delay({"/dev/ttyS0"}), milliseconds(0));
}

TEST(SettingsFinding, CannotSayTheParityOfAPseudoTerminal) {
  EXPECT_EQ(settings_finding({modbus::Baud{19200}, {}}, std::nullopt, true),
            (Finding{Judgement::unknown, "settings",
                     "19200 8E1 is set, but a pseudo-terminal has no parity to read back"}));
}

TEST(SettingsFinding, SaysWhyThePortCannotHaveTheMode) {
  const LineMode mode{modbus::Baud{250000}, {8, modbus::Parity::odd, 1}};
  EXPECT_EQ(settings_finding(mode, std::nullopt, false),
            (Finding{Judgement::ok, "settings", "250000 8O1 is set and was read back"}));
  EXPECT_EQ(
      settings_finding(mode, "the driver took 230400 baud instead", false),
      (Finding{Judgement::fault, "settings", "250000 8O1: the driver took 230400 baud instead",
               "this adapter cannot do it: take another rate or parity, here and at the "
               "drives, or another adapter"}));
}

}  // namespace
}  // namespace mbgate::ctl
