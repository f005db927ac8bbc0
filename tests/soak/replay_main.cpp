// SPDX-License-Identifier: Apache-2.0
// gateway_replay FILE [PROFILES]: plays a recording of mbgated --record to the machine. PROFILES is
// a folder of profiles in place of those that the recording was made with. Exits 0 if every action
// is the recorded one, 1 if not, 64 if it cannot be said.
#include <sysexits.h>

#include <cstdlib>
#include <fstream>
#include <iostream>

#include "soak/replay.hpp"

int main(int argc, char** argv) {
  if (argc != 2 && argc != 3) {
    std::cerr << "usage: gateway_replay FILE [PROFILES]\n";
    return EX_USAGE;
  }
  std::ifstream recording(argv[1], std::ios::binary);
  if (!recording) {
    std::cerr << "gateway_replay: cannot read " << argv[1] << '\n';
    return EX_USAGE;
  }
  const auto profiles = argc == 3 ? std::optional<std::filesystem::path>(argv[2]) : std::nullopt;
  const auto outcome = mbgate::test::replay(recording, profiles);
  std::cout << to_text(outcome) << '\n';
  return outcome.difference.empty() ? EXIT_SUCCESS : EXIT_FAILURE;
}
