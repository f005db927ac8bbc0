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
  {
    const Allocating in_arena(Allocating::Where::in_arena);
    world_ = std::make_unique<World>(plant_, bounds_);
  }
  enter();
  while (!steps_.empty()) {
    if (steps_.back().next == steps_.back().choices.size()) {
      if (!steps_.back().arena.empty()) {
        spare_.push_back(std::move(steps_.back().arena));
      }
      steps_.pop_back();
      if (!path_.empty()) {
        path_.pop_back();
      }
    } else if (!go_down()) {
      path_.pop_back();
    }
  }
  world_.reset();
  findings_.memory = known_.bytes();
  return std::move(findings_);
}

// Makes a choice in the state of the last step.
void Explorer::take(Step& step, const Choice& choice) {
  if (step.is_left) {
    put_back(step.arena);
  }
  step.is_left = true;
  const Allocating in_arena(Allocating::Where::in_arena);
  world_->take(choice);
}

// False: nothing new is there.
bool Explorer::go_down() {
  Step& step = steps_.back();
  path_.push_back(step.next++);
  take(step, step.choices[path_.back()]);
  if (world_->is_beyond()) {
    return false;
  }
  ++findings_.transitions;
  findings_.learning += world_->learning() - step.learning;
  if (!world_->violation().empty()) {
    note_violation(world_->violation());
    return false;
  }
  return enter();
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

Explorer::Step Explorer::here() {
  Step step{.learning = world_->learning()};
  {
    const Allocating in_arena(Allocating::Where::in_arena);
    const std::vector<Choice> choices = world_->choices();
    const Allocating elsewhere(Allocating::Where::elsewhere);
    step.choices = choices;
  }
  if (!world_->violation().empty()) {
    step.choices.clear();
  }
  if (step.choices.size() > 1 || merging_ == Merging::compared) {
    if (!spare_.empty()) {
      step.arena = std::move(spare_.back());
      spare_.pop_back();
    }
    copy_arena(step.arena);
  }
  return step;
}

Digest Explorer::digest() {
  const Allocating in_arena(Allocating::Where::in_arena);
  return world_->digest();
}

Digest Explorer::seen() {
  const Allocating in_arena(Allocating::Where::in_arena);
  return world_->seen();
}

bool Explorer::enter() {
  const Digest state = merging_ == Merging::off ? Digest{} : digest();
  const bool is_new = merging_ == Merging::off ||
                      known_.add(state, bit(world_->slack()), covering(world_->slack()));
  findings_.merged += is_new ? 0U : 1U;
  if (!is_new && merging_ != Merging::compared) {
    return false;
  }
  Step step = here();
  if (is_new) {
    ++findings_.states;
    if (!world_->violation().empty()) {
      note_violation(world_->violation());
    }
    findings_.ends += step.choices.empty() ? 1U : 0U;
    findings_.deepest = std::max(findings_.deepest, path_.size());
  }
  if (merging_ == Merging::compared) {
    compare(with(state, world_->slack()), step);
  }
  if (is_new) {
    steps_.push_back(std::move(step));
  }
  return is_new;
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
Digest Explorer::behaviour_of(Step& step) {
  StateHash hash{Instant{}};
  for (const Choice& choice : step.choices) {
    take(step, choice);
    if (world_->is_beyond()) {
      continue;
    }
    hash.add(choice.act);
    hash.add(choice.ask.client);
    hash.add(choice.ask.device);
    hash.add(choice.ask.word);
    for (const Digest& part : {seen(), with(digest(), world_->slack())}) {
      hash.add(part.first);
      hash.add(part.second);
    }
    hash.add(world_->violation().size());
  }
  return hash.digest();
}

void Explorer::compare(const Digest& state, Step& step) {
  const Digest behaviour = behaviour_of(step);
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
