// SPDX-License-Identifier: Apache-2.0
#include "app/systemd.hpp"

#include <systemd/sd-daemon.h>

#include <cstdlib>

namespace mbgate::app {

std::vector<InheritedSocket> take_inherited_sockets() {
  std::vector<InheritedSocket> sockets;
  char** names = nullptr;
  const int count = ::sd_listen_fds_with_names(1, &names);
  for (int i = 0; i < count; ++i) {
    sockets.push_back({names[i], io::UniqueFd(SD_LISTEN_FDS_START + i)});
    std::free(names[i]);
  }
  std::free(names);
  return sockets;
}

void notify_ready(const std::string& status) {
  ::sd_notify(0, ("READY=1\nSTATUS=" + status).c_str());
}

void notify_status(const std::string& status) { ::sd_notify(0, ("STATUS=" + status).c_str()); }

void notify_stopping() { ::sd_notify(0, "STOPPING=1\nSTATUS=stopping"); }

}  // namespace mbgate::app
