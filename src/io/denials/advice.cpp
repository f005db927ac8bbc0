// SPDX-License-Identifier: Apache-2.0
#include "io/denials/advice.hpp"

#include <array>
#include <cerrno>
#include <cstdio>
#include <fstream>
#include <limits>

namespace mbgate::io {
namespace {

constexpr unsigned kFirstFreePort = 1024;
constexpr mode_t kGroupReadsAndWrites = 0060;
constexpr mode_t kPermissions = 07777;

const std::string kDropIns = "/etc/systemd/system/mbgated.service.d/";
const std::string kTakeEffect =
    R"(, then run "systemctl daemon-reload" and "systemctl restart mbgated")";

std::string copy_of(const std::string& drop_in) {
  return "copy /usr/share/doc/mbgate/examples/" + drop_in + " to " + kDropIns + kTakeEffect;
}

/// As ListenStream= has it.
std::string stream_of(const gateway::ListenerSettings& listener) {
  const bool is_v6 = listener.address.find(':') != std::string::npos;
  return (is_v6 ? "[" + listener.address + "]" : listener.address) + ":" +
         std::to_string(listener.port);
}

/// The lines that make the shipped unit one for this listener; none if it is one.
std::string lines_of(const gateway::ListenerSettings& listener, bool is_http) {
  const std::string stream = R"("ListenStream=", "ListenStream=)" + stream_of(listener) + R"(")";
  if (is_http) {
    return R"("[Socket]", )" + stream;
  }
  const bool is_everywhere = listener.address == "0.0.0.0" || listener.address == "::";
  if (listener.name == "plant" && listener.port == 502 && is_everywhere) {
    return {};
  }
  return R"("[Socket]", "FileDescriptorName=)" + listener.name + R"(", )" + stream;
}

/// A socket unit has one FileDescriptorName=, so a second listener takes a unit of its own.
std::string copied_unit_steps(const gateway::ListenerSettings& listener) {
  const std::string unit = "mbgated-" + listener.name + ".socket";
  return "copy /lib/systemd/system/mbgated.socket to /etc/systemd/system/" + unit +
         R"(, with the lines "Service=mbgated.service", "FileDescriptorName=)" + listener.name +
         R"(", "ListenStream=", "ListenStream=)" + stream_of(listener) +
         R"(" in its section [Socket], and run "systemctl stop mbgated", "systemctl enable )" +
         unit + R"(", "systemctl start mbgated")";
}

/// How systemd comes to open the port.
std::string socket_steps(const gateway::ListenerSettings& listener, SocketUnit shipped) {
  const bool is_http = listener.name == "http";
  if (!is_http && shipped == SocketUnit::taken) {
    return "let systemd open it: " + copied_unit_steps(listener);
  }
  const std::string unit = is_http ? "mbgated-http.socket" : "mbgated.socket";
  const std::string lines = lines_of(listener, is_http);
  return R"(let systemd open it: run "systemctl stop mbgated", )" +
         (lines.empty() ? ""
                        : R"("systemctl edit )" + unit + R"(" with the lines )" + lines + ", ") +
         R"("systemctl enable )" + unit + R"(", "systemctl start mbgated")";
}

/// Which sockets the process may not make. IPv6 alone may be missing for another reason.
std::string forbidden_family(FamilyErrors errors, Starter starter) {
  const bool is_service = starter == Starter::systemd;
  if (!is_denial(errors.v4)) {
    return is_service ? "; this machine has no IPv6, or RestrictAddressFamilies= of the unit lacks "
                        "AF_INET6"
                      : "; has this machine no IPv6?";
  }
  if (is_service && errors.wanted == EAFNOSUPPORT) {
    return "; the service may make no network sockets (RestrictAddressFamilies=, as in the drop-in "
           "socket-only.conf)";
  }
  return "; this process may make no network sockets: a filter of system calls or a security "
         "module forbids it";
}

bool is_socket_only(FamilyErrors errors, Starter starter) {
  return starter == Starter::systemd && is_denial(errors.v4) && errors.wanted == EAFNOSUPPORT;
}

std::string without_socket_only() {
  return "remove " + kDropIns + "socket-only.conf" + kTakeEffect;
}

std::string octal(mode_t mode) {
  std::array<char, 16> text{};
  std::snprintf(text.data(), text.size(), "%04o", mode & kPermissions);
  return text.data();
}

}  // namespace

bool is_denial(int error) { return error == EACCES || error == EPERM || error == EAFNOSUPPORT; }

std::string port_advice(const gateway::ListenerSettings& listener, int error, SocketUnit shipped,
                        Starter starter) {
  if (error != EACCES || listener.port >= kFirstFreePort) {
    return starter == Starter::systemd
               ? "; SocketBindDeny= of the unit or a security module forbids this port"
               : "; a security module forbids this port";
  }
  if (starter == Starter::systemd) {
    return "; the service may open no port below 1024: " + socket_steps(listener, shipped) +
           "; or " + copy_of("port-502.conf");
  }
  return "; a port below 1024 needs the capability CAP_NET_BIND_SERVICE, one from 1024 on needs "
         "none";
}

std::string listen_advice(const gateway::ListenerSettings& listener, FamilyErrors errors,
                          SocketUnit shipped, Starter starter) {
  return forbidden_family(errors, starter) +
         (is_socket_only(errors, starter)
              ? ": " + socket_steps(listener, shipped) + "; or " + without_socket_only()
              : "");
}

std::string connect_advice(FamilyErrors errors, Starter starter) {
  return forbidden_family(errors, starter) +
         (is_socket_only(errors, starter) ? ": " + without_socket_only() : "");
}

std::string folder_advice(const std::string& folder, int error, const std::string& instead,
                          Starter starter) {
  if (error != EACCES && error != EROFS) {
    return {};
  }
  if (starter == Starter::somebody) {
    return error == EACCES ? "; the user that mbgated runs as may not write into " + folder : "";
  }
  return "; the service may not write there: " + instead + "; or " +
         (error == EACCES ? "let the user mbgate write into " + folder
                          : R"(run "systemctl edit mbgated", paste the two lines "[Service]" and )"
                            R"("ReadWritePaths=)" +
                                folder + R"(", then run "systemctl restart mbgated")");
}

std::string lock_advice(Starter starter) {
  return starter == Starter::systemd
             ? "; the unit needs LimitMEMLOCK=infinity: " + copy_of("realtime.conf")
             : "; the limit of locked memory must be unlimited (\"ulimit -l unlimited\")";
}

std::string tty_advice(const std::string& device, const TtyAccess& access, Starter starter) {
  const bool is_known = !access.group.empty();
  if (access.mode && (*access.mode & kGroupReadsAndWrites) != kGroupReadsAndWrites) {
    return "; its mode " + octal(*access.mode) +
           " lets no group use it: a udev rule must give it to the group dialout with mode 0660";
  }
  if (is_known && access.is_member) {
    return "; its mode and group allow it: the mount option nodev or a security module forbids it";
  }
  const std::string group = is_known ? access.group : "GROUP";
  const std::string who =
      "; the user that mbgated runs as must be in the group " +
      (is_known ? group : R"(of this port, mostly dialout ("ls -lL )" + device + R"(" names it))");
  return starter == Starter::systemd
             ? who +
                   R"(: run "systemctl edit mbgated", paste the two lines "[Service]" and )"
                   R"("SupplementaryGroups=)" +
                   group + R"(", then run "systemctl restart mbgated")"
             : who + R"(: run "sudo adduser NAME )" + group + R"(", then log in again)";
}

// Two lines of titles, then "  lo: ..." for each interface.
bool is_loopback_alone(std::istream& devices) {
  constexpr auto kAll = std::numeric_limits<std::streamsize>::max();
  devices.ignore(kAll, '\n').ignore(kAll, '\n');
  std::size_t count = 0;
  bool is_alone = true;
  for (std::string line; std::getline(devices, line); ++count) {
    const auto start = line.find_first_not_of(' ');
    is_alone = is_alone && start != std::string::npos && line.compare(start, 3, "lo:") == 0;
  }
  return is_alone && count == 1;
}

std::string network_advice(Starter starter) {
  std::ifstream devices("/proc/self/net/dev");
  if (!is_loopback_alone(devices)) {
    return {};
  }
  return std::string("; there is no network interface here but lo") +
         (starter == Starter::systemd
              ? ": PrivateNetwork=yes of the unit (as in the drop-in socket-only.conf) hides the "
                "others, or there are none yet"
              : "");
}

}  // namespace mbgate::io
