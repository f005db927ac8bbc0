// SPDX-License-Identifier: Apache-2.0
// Goes through all that may happen in a small world within its bounds, depth first. Where it comes
// to a state that it knows, it turns back. A gateway cannot be copied: to go back, the memory in
// which it lies is made what it was (arena.hpp).
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "explore/arena.hpp"
#include "explore/known_states.hpp"
#include "explore/world.hpp"

namespace mbgate::explore {

using Path = std::vector<std::uint16_t>;  ///< the places of the choices among those there were

struct Violation {
  std::string what;
  Path path;
};

struct Findings {
  std::uint64_t states = 0;
  std::uint64_t transitions = 0;
  std::uint64_t merged = 0;  ///< transitions to a state that was known
  std::uint64_t ends = 0;    ///< states with no choice left
  std::size_t deepest = 0;
  std::size_t memory = 0;      ///< bytes of the states that are known
  std::uint64_t learning = 0;  ///< transitions with an answer that nobody could know to be wrong
  std::uint64_t violated = 0;  ///< paths that end in a violation
  std::vector<Violation> violations;  ///< the shortest of each kind
};

enum class Merging : std::uint8_t {
  on,
  off,      ///< every path is gone to its end
  compared  ///< a state that is reached once more must have the same choices with the same outcomes
};

class Explorer {
 public:
  Explorer(const Plant& plant, const Bounds& bounds, Merging merging)
      : plant_(plant), bounds_(bounds), merging_(merging) {}
  Findings run();

 private:
  /// A state on the way to the present one.
  struct Step {
    std::vector<Choice> choices{};
    std::uint16_t next = 0;
    unsigned learning = 0;
    std::vector<std::byte> arena{};  ///< the world; with one choice nobody comes back to it
    bool is_left = false;
  };

  void take(Step& step, const Choice& choice);
  bool go_down();
  [[nodiscard]] Step here();
  [[nodiscard]] Digest digest();
  [[nodiscard]] Digest seen();
  bool enter();
  [[nodiscard]] SlackSet bit(const Slack& slack) const;
  [[nodiscard]] SlackSet covering(const Slack& slack) const;
  void note_violation(const std::string& what);
  void compare(const Digest& state, Step& step);
  [[nodiscard]] Digest behaviour_of(Step& step);

  const Plant& plant_;
  Bounds bounds_;
  Merging merging_;
  KnownStates known_;
  std::map<Digest, Digest> behaviours_;
  std::unique_ptr<World> world_;  ///< and all that it owns: in the arena
  std::vector<Step> steps_;
  std::vector<std::vector<std::byte>> spare_;  ///< the memory of steps that are over
  Path path_;
  Findings findings_;
};

/// Makes the choices of a path, and tells each step. The violation that it ends in, if any.
std::string replay(const Plant& plant, const Bounds& bounds, const Path& path);

}  // namespace mbgate::explore
