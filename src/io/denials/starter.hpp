// SPDX-License-Identifier: Apache-2.0
// Who started this process. What helps against a refusal of the system depends on it.
#pragma once

#include <cstdint>

namespace mbgate::io {

enum class Starter : std::uint8_t {
  systemd,   ///< as a service of the machine: its unit says what the process may do
  somebody,  ///< a person, a container, a service of a user
};

/// systemd tells a process by its number that it is the one of the unit (SYSTEMD_EXEC_PID of
/// systemd.exec, since version 248). INVOCATION_ID would be there in every shell that some service
/// has started.
Starter starter();

}  // namespace mbgate::io
