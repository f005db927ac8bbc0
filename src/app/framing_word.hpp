// SPDX-License-Identifier: Apache-2.0
// The framing of a line as it stands in JSON (docs/api.yaml).
#pragma once

#include "bus/settings.hpp"

namespace mbgate::app {

constexpr const char* framing_word(bus::Framing framing) {
  switch (framing) {
    case bus::Framing::rtu: return "rtu";
    case bus::Framing::ascii: return "ascii";
    case bus::Framing::tcp: return "tcp";
  }
  return "";
}

}  // namespace mbgate::app
