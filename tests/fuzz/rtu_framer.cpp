// SPDX-License-Identifier: Apache-2.0
// RTU: whatever comes from the line, a response is one.
#include "fuzz/framer.hpp"

namespace mbgate::fuzz::rtu_framer_target {

MBGATE_FUZZ_TARGET(rtu_framer) {
  FramerScript(bus::Framing::rtu, Script(data, size)).run();
  return 0;
}

}  // namespace mbgate::fuzz::rtu_framer_target
