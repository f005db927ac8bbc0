// SPDX-License-Identifier: Apache-2.0
// A simulated plant in which the input decides what clients ask and what goes wrong: the judge
// finds nothing.
#include "fuzz/fuzz.hpp"
#include "judge/judge.hpp"

namespace mbgate::fuzz {
namespace {

/// Two bytes draw the plant, the others are what is drawn afterwards.
void run(Script script) {
  constexpr std::uint64_t kTransactions = 100;
  world::World world(world::draw_plan(script.word()), false);
  world::Random::follow(script.rest());
  judge::Judge judge(world);
  world.be_watched_by(judge);
  world.run(kTransactions);
  world::Random::follow({});
  world.come_to_rest();
  judge.check_rest();
  world.shut_down();
  judge.check_end();
  for (const std::string& text : world.report().texts) {
    require(false, text.c_str());
  }
}

}  // namespace
}  // namespace mbgate::fuzz

MBGATE_FUZZ_TARGET(plant) {
  mbgate::fuzz::run({data, size});
  return 0;
}
