// SPDX-License-Identifier: Apache-2.0
// A broken invariant ends the process, in every build, and says which one it was.
#include "bus_rig.hpp"

namespace mbgate::test {
namespace {

class Invariants : public Bus {};

TEST_F(Invariants, AJobThatIsSubmittedTwiceEndsTheProcess) {
  open(settings());
  bus::Job& waiting = job("03 0000 0001");
  submit(job("03 0000 0002"));
  submit(waiting);
  EXPECT_DEATH(submit(waiting), "broken invariant: a job is submitted once \\(.*admission\\.cpp:");
}

}  // namespace
}  // namespace mbgate::test
