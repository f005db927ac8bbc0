// SPDX-License-Identifier: Apache-2.0
// ASCII: whatever comes from the line, a response is one.
#include "fuzz/framer.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace mbgate;
  fuzz::FramerScript(bus::Framing::ascii, fuzz::Script(data, size)).run();
  return 0;
}
