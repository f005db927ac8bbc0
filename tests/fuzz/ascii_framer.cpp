// SPDX-License-Identifier: Apache-2.0
// ASCII: whatever comes from the line, a response is one.
#include "fuzz/framer.hpp"

namespace mbgate::fuzz::ascii_framer_target {

MBGATE_FUZZ_TARGET(ascii_framer) {
  FramerScript(bus::Framing::ascii, Script(data, size)).run();
  return 0;
}

}  // namespace mbgate::fuzz::ascii_framer_target
