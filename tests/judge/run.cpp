// SPDX-License-Identifier: Apache-2.0
#include "judge/run.hpp"

#include <exception>
#include <new>

#include "judge/judge.hpp"
#include "judge/rules_judge.hpp"

namespace mbgate::judge {

world::Report run(world::Plan plan, const Course& course) {
  world::Report failed;
  try {
    world::World world(std::move(plan), course.trace);
    Judge judge(world);
    RulesJudge rules(world, judge);
    world.be_watched_by(rules);
    course.prepare(world);
    const auto begun = world.now();
    world.run(course.transactions);
    world.come_to_rest();
    rules.check_counters();
    judge.check_rest();
    rules.check_status();
    world.shut_down();
    judge.check_end();
    world.report().virtual_time = world.now() - begun;
    return world.report();
  } catch (const std::bad_alloc&) {
    failed.violation("no_progress", "the gateway takes memory without end");
  } catch (const std::exception& error) {
    failed.violation("thrown", error.what());
  }
  return failed;
}

}  // namespace mbgate::judge
