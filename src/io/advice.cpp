// SPDX-License-Identifier: Apache-2.0
#include "io/advice.hpp"

#include <cerrno>

namespace mbgate::io {
namespace {

constexpr unsigned kFirstFreePort = 1024;

/// A filter of system calls refuses sockets with either.
bool is_refused_family(int error) { return error == EAFNOSUPPORT || error == EPERM; }

constexpr const char* kNoSockets =
    "; this process may make no such sockets: the drop-in socket-only.conf of the service "
    "(RestrictAddressFamilies=) or a security module forbids it, or this machine has no IPv6";

}  // namespace

bool is_denial(int error) { return error == EACCES || is_refused_family(error); }

std::string listen_advice(std::uint16_t port, int error) {
  if (is_refused_family(error)) {
    return std::string(kNoSockets) + "; mbgated.socket lets systemd open it";
  }
  if (error != EACCES) {
    return {};
  }
  return port < kFirstFreePort
             ? "; a port below 1024 needs the capability CAP_NET_BIND_SERVICE: let systemd open it "
               "(mbgated.socket), or give the service the drop-in port-502.conf"
             : "; SocketBindDeny= of the unit or a security module forbids this port";
}

std::string connect_advice(int error) {
  if (error == ENETUNREACH) {
    return "; with the drop-in socket-only.conf (PrivateNetwork=) the service has no network";
  }
  return is_refused_family(error) ? kNoSockets : "";
}

std::string folder_advice(const std::string& folder, int error, const std::string& instead) {
  if (error != EACCES && error != EROFS) {
    return {};
  }
  return "; the user that mbgated runs as must be able to write into " + folder +
         " (of the service: ReadWritePaths=), or " + instead;
}

}  // namespace mbgate::io
