// SPDX-License-Identifier: Apache-2.0
#include "app/control/asker.hpp"

#include <sys/socket.h>

namespace mbgate::app {
namespace {

/// What the kernel says where a user is none of those that the service may see (PrivateUsers= of
/// its unit): kernel.overflowuid, which nobody changes.
constexpr uid_t kHiddenUser = 65534;

}  // namespace

Asker asker_of(const routing::ClientAddress& address) {
  return {address.counted_as().to_text(), address.to_text()};
}

// No name of the user: it could come from a server, and be waited for.
Asker asker_of_unix_socket(int descriptor) {
  ucred peer{};
  socklen_t size = sizeof peer;
  if (::getsockopt(descriptor, SOL_SOCKET, SO_PEERCRED, &peer, &size) != 0) {
    return {"unknown", "an unknown process"};
  }
  const std::string user = "uid " + std::to_string(peer.uid);
  return {user, user + (peer.uid == kHiddenUser ? " (neither root nor the service's own)" : "") +
                    ", pid " + std::to_string(peer.pid)};
}

}  // namespace mbgate::app
