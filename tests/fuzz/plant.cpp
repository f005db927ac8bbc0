// SPDX-License-Identifier: Apache-2.0
// A simulated plant in which the input decides what clients ask and what goes wrong: the judge
// finds nothing.
#include "fuzz/fuzz.hpp"
#include "judge/run.hpp"

namespace mbgate::fuzz {
namespace {

/// Two bytes draw the plant, the others are what is drawn afterwards.
void run(Script script) {
  const world::Plan plan = world::draw_plan(script.word());
  world::Random::follow(script.rest());
  const world::Report report = judge::run(plan, {.transactions = 100});
  world::Random::follow({});
  for (const std::string& text : report.texts) {
    require(false, text.c_str());
  }
}

}  // namespace
}  // namespace mbgate::fuzz

MBGATE_FUZZ_TARGET(plant) {
  mbgate::fuzz::run({data, size});
  return 0;
}
