// SPDX-License-Identifier: Apache-2.0
#include "io/denials/starter.hpp"

#include <unistd.h>

#include <cstdlib>
#include <string>

namespace mbgate::io {

Starter starter() {
  const char* const started = std::getenv("SYSTEMD_EXEC_PID");
  const bool is_of_user = std::getenv("MANAGERPID") != nullptr;
  return started != nullptr && started == std::to_string(::getpid()) && !is_of_user
             ? Starter::systemd
             : Starter::somebody;
}

}  // namespace mbgate::io
