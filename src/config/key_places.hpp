// SPDX-License-Identifier: Apache-2.0
// The places of keys that deny requests, such as "mbgate.toml:12". The gateway does not need them;
// `--check --who` names them.
#pragma once

#include <string>
#include <vector>

namespace mbgate::config {

/// Empty: the key is not there.
struct ListenerPlaces {
  std::string allow;
  std::string read_only;
};

/// Of a key that is not there, where the route begins.
struct RoutePlaces {
  std::string access;
  std::string functions;
  std::string windows;  ///< the first of them
};

struct KeyPlaces {
  std::vector<ListenerPlaces> listeners{};
  std::vector<RoutePlaces> routes{};
  std::vector<std::string> writers{};  ///< of the devices
};

}  // namespace mbgate::config
