// SPDX-License-Identifier: Apache-2.0
// What helps where the system does not let this process do something: for the service the drop-in
// or the socket unit, for others what an ordinary process needs. Each text begins with "; ", to
// follow what the system said, or is empty where the cause is not certain.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <istream>
#include <optional>
#include <string>

#include "gateway/settings.hpp"
#include "io/denials/starter.hpp"

namespace mbgate::io {

/// Does it fail again until somebody allows it? EACCES, EPERM and EAFNOSUPPORT are no weather.
bool is_denial(int error);

/// mbgated.socket, as shipped: free, or another listener's already.
enum class SocketUnit : std::uint8_t { free, taken };

/// bind() has failed with `error`, a denial.
std::string port_advice(const gateway::ListenerSettings& listener, int error, SocketUnit shipped,
                        Starter starter);

/// What socket() said for the family that is wanted, and for IPv4.
struct FamilyErrors {
  int wanted = 0;
  int v4 = 0;
};

/// socket() has failed with a denial: for a listener, whose socket may come from systemd, or for a
/// connection that we make.
std::string listen_advice(const gateway::ListenerSettings& listener, FamilyErrors errors,
                          SocketUnit shipped, Starter starter);
std::string connect_advice(FamilyErrors errors, Starter starter);

/// A file or socket could not be made in this folder. `instead`: what the service may do.
std::string folder_advice(const std::string& folder, int error, const std::string& instead,
                          Starter starter);

/// Memory cannot be locked because there is a limit for it.
std::string lock_advice(Starter starter);

/// What a tty's file lets its group do, and whether we are in it.
struct TtyAccess {
  std::optional<mode_t> mode;  ///< nothing: its file cannot be looked at
  std::string group;           ///< empty: it is not known here
  bool is_member = false;
};

/// open() of a tty has failed with EACCES.
std::string tty_advice(const std::string& device, const TtyAccess& access, Starter starter);

/// Is the loopback interface the only one? `devices` is what /proc/self/net/dev contains.
bool is_loopback_alone(std::istream& devices);
/// The same, asked of the system, for a host that cannot be reached or found.
std::string network_advice(Starter starter);

}  // namespace mbgate::io
