// SPDX-License-Identifier: Apache-2.0
#include "explore/explorer.hpp"

#include <algorithm>

namespace mbgate::explore {
namespace {

// The state with its slack.
Digest with(const Digest& state, const Slack& slack) {
  StateHash hash{Instant{}};
  hash.add(state.first);
  hash.add(state.second);
  hash.add(slack.faults);
  hash.add(slack.delays);
  hash.add(slack.is_undisturbed);
  return hash.digest();
}

}  // namespace

Findings Explorer::run() {
  auto world = again();
  enter(*world);
  while (!steps_.empty()) {
    Step& step = steps_.back();
    if (step.next == step.choices.size()) {
      steps_.pop_back();
      if (!path_.empty()) {
        path_.pop_back();
      }
      world.reset();
      continue;
    }
    if (!world) {
      world = again();
    }
    if (!go_down(*world)) {
      path_.pop_back();
      world.reset();
    }
  }
  findings_.memory = known_.bytes();
  return std::move(findings_);
}

std::unique_ptr<World> Explorer::again() const {
  auto world = std::make_unique<World>(plant_, bounds_);
  for (std::size_t at = 0; at < path_.size(); ++at) {
    world->take(steps_[at].choices[path_[at]]);
  }
  return world;
}

// False: nothing new is there.
bool Explorer::go_down(World& world) {
  Step& step = steps_.back();
  path_.push_back(step.next++);
  const unsigned before = world.learning();
  world.take(step.choices[path_.back()]);
  if (world.is_beyond()) {
    return false;
  }
  ++findings_.transitions;
  findings_.learning += world.learning() - before;
  if (!world.violation().empty()) {
    note_violation(world.violation());
    return false;
  }
  return enter(world);
}

// The bit of a slack. Each of faults and delays may be all that is allowed, or less.
SlackSet Explorer::bit(const Slack& slack) const {
  return SlackSet{1} << (2 * (slack.faults * (bounds_.delays + 1) + slack.delays) +
                         (slack.is_undisturbed ? 1U : 0U));
}

// As much slack, or more: all that may happen with this one may happen with it.
SlackSet Explorer::covering(const Slack& slack) const {
  SlackSet all = 0;
  for (unsigned faults = slack.faults; faults <= bounds_.faults; ++faults) {
    for (unsigned delays = slack.delays; delays <= bounds_.delays; ++delays) {
      all |= bit({faults, delays, true});
      all |= slack.is_undisturbed ? 0U : bit({faults, delays, false});
    }
  }
  return all;
}

bool Explorer::enter(World& world) {
  if (merging_ != Merging::off) {
    const Digest state = world.digest();
    const bool is_new = known_.add(state, bit(world.slack()), covering(world.slack()));
    if (merging_ == Merging::compared) {
      compare(with(state, world.slack()), world);
    }
    if (!is_new) {
      ++findings_.merged;
      return false;
    }
  }
  ++findings_.states;
  steps_.push_back({world.choices()});
  if (!world.violation().empty()) {
    note_violation(world.violation());
    steps_.back().choices.clear();
  }
  findings_.ends += steps_.back().choices.empty() ? 1U : 0U;
  findings_.deepest = std::max(findings_.deepest, path_.size());
  return true;
}

void Explorer::note_violation(const std::string& what) {
  ++findings_.violated;
  const auto known = std::ranges::find(findings_.violations, what, &Violation::what);
  if (known == findings_.violations.end()) {
    findings_.violations.push_back({what, path_});
  } else if (path_.size() < known->path.size()) {
    known->path = path_;
  }
}

// What may happen in a state, and what comes of each of it.
Digest Explorer::behaviour_of(World& world) const {
  const std::vector<Choice> choices = world.choices();
  StateHash hash{Instant{}};
  for (const Choice& choice : choices) {
    const auto next = again();
    next->take(choice);
    if (next->is_beyond()) {
      continue;
    }
    hash.add(choice.act);
    hash.add(choice.ask.client);
    hash.add(choice.ask.device);
    hash.add(choice.ask.word);
    for (const Digest& part : {next->seen(), with(next->digest(), next->slack())}) {
      hash.add(part.first);
      hash.add(part.second);
    }
    hash.add(next->violation().size());
  }
  return hash.digest();
}

void Explorer::compare(const Digest& state, World& world) {
  const Digest behaviour = behaviour_of(world);
  const auto [known, added] = behaviours_.try_emplace(state, behaviour);
  if (!added && known->second != behaviour) {
    note_violation("merging: a state behaves otherwise than when it was reached first");
  }
}

std::string replay(const Plant& plant, const Bounds& bounds, const Path& path) {
  World world(plant, bounds, true);
  for (const std::uint16_t place : path) {
    const std::vector<Choice> choices = world.choices();
    if (!world.violation().empty()) {
      break;
    }
    if (place >= choices.size()) {
      return "there is no such choice";
    }
    world.take(choices[place]);
  }
  static_cast<void>(world.choices());
  return world.violation();
}

}  // namespace mbgate::explore
