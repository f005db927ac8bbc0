// SPDX-License-Identifier: Apache-2.0
// A gateway that may do less than its configuration needs, as the units of systemd make it: no
// sockets of a network, no port below 1024, no network. A filter of system calls, capabilities and
// namespaces refuse here as they do there.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <linux/capability.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <netinet/in.h>
#include <sched.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <bit>
#include <cerrno>
#include <csignal>
#include <cstddef>
#include <fstream>

#include "integration/plant.hpp"

namespace mbgate::test {
namespace {

constexpr const char* kListener = "[[listen]]\nname = \"plant\"\nbus = \"a\"\n";
constexpr const char* kSerialBus = "[[bus]]\nname = \"a\"\ndevice = \"/dev/serial/by-id/none\"\n";
constexpr const char* kServerBus = "[[bus]]\nname = \"a\"\nmode = \"tcp\"\nhost = \"192.0.2.77\"\n";
constexpr const char* kNoControl = "[http]\nsocket = \"\"\n";
constexpr const char* kNoSockets =
    "Address family not supported by protocol; this process may make no such sockets: the drop-in "
    "socket-only.conf of the service (RestrictAddressFamilies=) or a security module forbids it, "
    "or "
    "this machine has no IPv6";

/// What RestrictAddressFamilies=AF_UNIX of a unit does.
bool forbid_network_sockets() {
  constexpr std::size_t kLowHalf = std::endian::native == std::endian::little ? 0 : 4;
  std::array program{
      sock_filter BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, nr)),
      sock_filter BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, __NR_socket, 0, 3),
      sock_filter BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, args) + kLowHalf),
      sock_filter BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, AF_UNIX, 1, 0),
      sock_filter BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ERRNO | EAFNOSUPPORT),
      sock_filter BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW),
  };
  const sock_fprog filter{static_cast<unsigned short>(program.size()), program.data()};
  return prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0 &&
         prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &filter) == 0;
}

/// What CapabilityBoundingSet= of a unit does; without root nothing is to be done.
void forbid_low_ports() { prctl(PR_CAPBSET_DROP, CAP_NET_BIND_SERVICE, 0, 0, 0); }

/// What PrivateNetwork=yes of a unit does.
bool leave_network() {
  return unshare(CLONE_NEWNET) == 0 || unshare(CLONE_NEWUSER | CLONE_NEWNET) == 0;
}

/// Does it work here, in another process?
bool can(const std::function<bool()>& action) {
  const pid_t child = fork();
  if (child == 0) {
    _exit(action() ? 0 : 1);
  }
  int status = 1;
  waitpid(child, &status, 0);
  return status == 0;
}

bool has_only_loopback() {
  std::ifstream devices("/proc/self/net/dev");
  std::string line;
  int count = 0;
  while (std::getline(devices, line)) {
    ++count;
  }
  return count == 3;
}

/// A socket of systemd's for the listener, at descriptor 3.
void hand_over(int listening) {
  dup2(listening, 3);
  setenv("LISTEN_FDS", "1", 1);
  setenv("LISTEN_FDNAMES", "plant", 1);
  setenv("LISTEN_PID", std::to_string(getpid()).c_str(), 1);
}

TEST(Denials, OfNetworkSocketsEndTheStartAndNameTheListener) {
  if (!can(forbid_network_sockets)) {
    GTEST_SKIP() << "skipped: no filter of system calls here";
  }
  TemporaryFolder folder;
  const auto config = folder.write(
      "mbgate.toml", std::string(kListener) + "port = 1502\n" + kServerBus + kNoControl);
  Process gateway("mbgated", {"--config", config.string()},
                  {folder.path(), [] { forbid_network_sockets(); }});
  EXPECT_EQ(gateway.wait_for_exit(), 78);
  EXPECT_EQ(gateway.output(),
            std::string("error: listener \"plant\": cannot listen on 127.0.0.1:1502: ") +
                kNoSockets + "; mbgated.socket lets systemd open it\n");
}

TEST(Denials, OfNetworkSocketsAreNamedByTheLineThatNeedsThem) {
  if (!can(forbid_network_sockets)) {
    GTEST_SKIP() << "skipped: no filter of system calls here";
  }
  const int listening = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  ASSERT_EQ(bind(listening, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
  ASSERT_EQ(listen(listening, 8), 0);
  TemporaryFolder folder;
  const auto config = folder.write(
      "mbgate.toml", std::string(kListener) + "port = 502\n" + kServerBus + kNoControl);
  Process gateway("mbgated", {"--config", config.string()}, {folder.path(), [listening] {
                                                               hand_over(listening);
                                                               forbid_network_sockets();
                                                             }});
  const auto port = gateway.port_of("plant");
  EXPECT_THAT(gateway.wait_for_line("cannot connect"),
              testing::HasSubstr(std::string("bus a: cannot connect to tcp://192.0.2.77:502: ") +
                                 kNoSockets));
  TcpClient client(port);  // it is served: the line is not there
  client.send(request(1, 1, "03 003C 0002"));
  EXPECT_EQ(text_of(client.receive().value_or(ByteString{})), "00 01 00 00 00 03 01 83 0A");
  close(listening);
}

TEST(Denials, OfALowPortEndTheStart) {
  int first_free = 0;
  std::ifstream("/proc/sys/net/ipv4/ip_unprivileged_port_start") >> first_free;
  if (first_free <= 502) {
    GTEST_SKIP() << "skipped: everybody may open port 502 here (ip_unprivileged_port_start)";
  }
  TemporaryFolder folder;
  const auto config = folder.write(
      "mbgate.toml", std::string(kListener) + "port = 502\n" + kSerialBus + kNoControl);
  Process gateway("mbgated", {"--config", config.string()}, {folder.path(), forbid_low_ports});
  EXPECT_EQ(gateway.wait_for_exit(), 78);
  EXPECT_EQ(gateway.output(),
            "error: listener \"plant\": cannot listen on 127.0.0.1:502: Permission denied; a port "
            "below 1024 needs the capability CAP_NET_BIND_SERVICE: let systemd open it "
            "(mbgated.socket), or give the service the drop-in port-502.conf\n");
}

TEST(Denials, OfANetworkAreNamedByTheLineThatNeedsIt) {
  if (!can([] { return leave_network() && has_only_loopback(); })) {
    GTEST_SKIP() << "skipped: no network namespace with nothing but lo can be had here";
  }
  TemporaryFolder folder;
  const auto config = folder.write(
      "mbgate.toml", std::string(kListener) + "port = 1502\n" + kServerBus + kNoControl);
  Process gateway("mbgated", {"--config", config.string()},
                  {folder.path(), [] { leave_network(); }});
  EXPECT_THAT(gateway.wait_for_line("cannot connect"),
              testing::HasSubstr(
                  "bus a: cannot connect to tcp://192.0.2.77:502: Network is unreachable; with the "
                  "drop-in socket-only.conf (PrivateNetwork=) the service has no network"));
}

}  // namespace
}  // namespace mbgate::test
