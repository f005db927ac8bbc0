// SPDX-License-Identifier: Apache-2.0
#include "world/world.hpp"

#include <algorithm>
#include <cstdio>
#include <utility>

namespace mbgate::world {
namespace {

constexpr std::uint64_t kWorldsChance = 0x574F524CULL;
constexpr std::uint64_t kChangesChance = 0x4348414EULL;
constexpr std::uint64_t kTakingChance = 0x54414B45ULL;
constexpr std::uint64_t kDriversChance = 0x44524956ULL;
constexpr std::uint64_t kMostRequests = 60;  // for each transmission that is to be seen
constexpr Duration kLongestRun = std::chrono::hours(20);
// A gateway that is well does a few thousand things in so short a time.
constexpr Duration kPlace = 10ms;
constexpr unsigned kMostInPlace = 200'000;

std::vector<Drive> make_drives(const Plan& plan) {
  std::vector<Drive> drives;
  for (std::size_t at = 0; at < plan.drives.size(); ++at) {
    drives.emplace_back(plan.drives[at], at, plan.seed * 1000 + at);
  }
  return drives;
}

}  // namespace

World::World(Plan plan, bool trace)
    : plan_(std::move(plan)),
      random_(plan_.seed ^ kWorldsChance),
      changes_(plan_.seed ^ kChangesChance),
      rights_(plan_.seed ^ kTakingChance),
      drives_(make_drives(plan_)),
      around_{plan_,
              schedule_,
              ledger_,
              report_,
              drives_,
              [this](std::size_t bus, const Octets& bytes, const Came& came) {
                deliver(bus, bytes, came);
              },
              [this](std::size_t bus) { lose(bus, bus::Loss::closed); }},
      buses_(plan_.lines.size()),
      harness_(std::in_place, plan_.settings, schedule_.now()),
      driver_(plan_.driver, buses_.size(), plan_.seed ^ kDriversChance, schedule_, hands()),
      asking_(plan_, random_),
      tools_{plan_,
             schedule_,
             random_,
             driver_,
             ledger_,
             report_,
             asking_,
             [this](const gateway::Input& input) { hand_in(input); },
             [this](Id id) { witness_->asked(id); },
             [this](Id id) { given(id); },
             [this](Id id) { answered(id); },
             [this](Id id) { witness_->gone(id); }},
      losses_(plan_.lines.size(), bus::Loss::failed),
      trace_(trace) {
  ledger_.lines.resize(plan_.lines.size());
  ledger_.open_reads.resize(plan_.stations.size());
  ledger_.last_sent.resize(plan_.stations.size());
  ledger_.stops.resize(plan_.stations.size());
  ledger_.started = schedule_.now();
  number_buses();
  for (std::size_t bus = 0; bus < buses_.size(); ++bus) {
    if (plan_.is_tcp(bus)) {
      wires_.emplace_back(std::in_place_type<Server>, bus, around_);
    } else {
      wires_.emplace_back(std::in_place_type<Line>, bus, around_);
    }
    std::visit([](auto& wire) { wire.begin_trouble(); }, wires_.back());
    begin_losses(bus);
  }
  for (const Manners& manners : plan_.clients) {
    clients_.emplace_back(manners, tools_).begin();
  }
  again(plan_.restarts_every, &World::restart);
  again(plan_.reloads_every, &World::reload);
  drain();
}

void World::trace(const std::string& text) const {
  if (trace_) {
    std::fprintf(stderr, "%10.6f %s\n",
                 static_cast<double>(schedule_.now().time_since_epoch().count()) / 1e9,
                 text.c_str());
  }
}

void World::run(std::uint64_t transactions) {
  const std::uint64_t requests = kMostRequests * transactions;
  const Instant latest = schedule_.now() + kLongestRun;
  while (report_.transactions < transactions && report_.requests < requests &&
         schedule_.now() < latest && step()) {
  }
}

bool World::step() {
  const auto wakes = driver_.wakes_at();
  const auto next = bus::earlier(schedule_.next(), wakes);
  if (schedule_.now() > place_ + kPlace) {
    place_ = schedule_.now();
    done_in_place_ = 0;
  }
  if (!stuck_ && ++done_in_place_ > kMostInPlace) {
    stuck_ = true;
    report_.violation("no_progress", "time does not go on");
  }
  if (!next || stuck_) {
    return false;
  }
  schedule_.advance(*next);
  if (wakes == next) {
    driver_.wake();
  } else {
    schedule_.run_one();
  }
  return true;
}

void World::run_until(Instant limit) {
  while (true) {
    const auto next = bus::earlier(schedule_.next(), driver_.wakes_at());
    if (!next || *next > limit || !step()) {
      break;
    }
  }
  schedule_.advance(limit);
}

Driver::Hands World::hands() {
  return {
      [this](std::size_t bus, Octets bytes) {
        trace(plan_.bus(bus).name + " < " + hex(bytes));
        hand_in(gateway::LineBytes{gateway::BusId{buses_[bus].id}, bytes});
      },
      [this](std::size_t bus) {
        hand_in(gateway::LineLost{gateway::BusId{buses_[bus].id},
                                  std::exchange(losses_[bus], bus::Loss::failed)});
      },
      [this] {
        for (std::size_t bus = 0; bus < buses_.size(); ++bus) {
          tell_unsent(bus);
        }
        hand_in(gateway::DeadlineReached{});
      },
      [this](Duration missed) {
        hand_in(gateway::Stalled{std::chrono::duration_cast<std::chrono::milliseconds>(missed)});
        for (Client& client : clients_) {
          client.be_read();
        }
      },
      [this] {
        const auto wake = harness_->next_wake();
        return wake ? std::optional(bus::Wake{wake->at, wake->silence_of.has_value()})
                    : std::nullopt;
      },
      [this](Duration time) {
        const Instant end = schedule_.now() + time;
        for (auto next = schedule_.next(); next && *next <= end; next = schedule_.next()) {
          schedule_.advance(*next);
          schedule_.run_one();
        }
        schedule_.advance(end);
      },
      [this](const char* kind) { report_.fault(kind); }};
}

void World::hand_in(const gateway::Input& input) {
  harness_->handle(input, schedule_.now());
  drain();
}

// Actions that set off others come back here; the outer call goes on with them. The gateway wants
// frames transmitted before answers are sent; both are one instant.
void World::drain() {
  if (draining_ || stuck_) {
    return;
  }
  draining_ = true;
  unsigned taken = 0;
  while (const auto action = harness_->gateway().poll_action()) {
    if (++taken > kMostInPlace) {
      stuck_ = true;
      report_.violation("no_progress", "the gateway's actions have no end");
      break;
    }
    carry_out(*action);
  }
  draining_ = false;
  if (!driver_.is_awake()) {
    driver_.set_timer();
  }
}

template <typename ForClient>
Client* World::find(const ForClient* action) {
  const auto found = std::ranges::find_if(clients_, [&](const Client& client) {
    return action != nullptr && client.is_connected() && client.number() == action->client;
  });
  return found == clients_.end() ? nullptr : &*found;
}

void World::carry_out(const gateway::Action& action) {
  if (trace_) {
    trace(test::action_text(action, harness_->settings()));
  }
  if (const auto* send = std::get_if<gateway::Send>(&action)) {
    if (Client* client = find(send)) {
      client->take({send->adu.data(), send->adu.size()});
    } else {
      report_.violation("nobodys_answer", "an answer for a client that has gone");
    }
  } else if (const auto* frame = std::get_if<gateway::Transmit>(&action)) {
    if (const auto bus = bus_of(frame->bus)) {
      transmit(*bus, Octets(frame->frame.data(), frame->frame.data() + frame->frame.size()));
    }
  } else if (const auto* look = std::get_if<gateway::Look>(&action)) {
    if (const auto bus = bus_of(look->bus)) {
      driver_.look(*bus);
      tell_unsent(*bus);
    }
    harness_->handle(gateway::LineLooked{look->bus}, schedule_.now());
  } else if (const auto* line = std::get_if<gateway::Open>(&action)) {
    if (const auto bus = bus_of(line->bus)) {
      open(*bus);
    }
  } else if (const auto* end = std::get_if<gateway::Shut>(&action)) {
    shut(static_cast<std::uint32_t>(end->bus));
  } else if (Client* paused = find(std::get_if<gateway::Pause>(&action))) {
    paused->pause();
  } else if (Client* resumed = find(std::get_if<gateway::Resume>(&action))) {
    resumed->resume();
  } else if (Client* closed = find(std::get_if<gateway::Close>(&action))) {
    report_.fault("closed_by_gateway");
    closed->be_cut_off();
  } else if (const auto* report = std::get_if<gateway::Report>(&action)) {
    events_.push_back(report->event);
  } else if (std::holds_alternative<gateway::Finished>(action)) {
    finished_ = true;
  }
}

void World::given(Id id) {
  const Asked& asked = ledger_.asked[id];
  if (asked.intent.station && asked.intent.kind == Kind::read && !asked.intent.refused) {
    ledger_.open_reads[*asked.intent.station].push_back(id);
  }
  if (asked.intent.station && asked.intent.kind == Kind::stop) {
    ledger_.stops[*asked.intent.station].push_back(id);
  }
  std::vector<std::size_t> places;
  if (asked.intent.station) {
    places.push_back(*asked.intent.station);
  } else {
    std::ranges::transform(asked.intent.buses, std::back_inserter(places), all_of);
  }
  for (const std::size_t place : places) {
    for (const Cell& cell : asked.intent.writes) {
      ledger_.writer[key_of(place, cell)] = id;
    }
  }
  witness_->given(id);
}

void World::answered(Id id) {
  const Asked& asked = ledger_.asked[id];
  if (asked.answer.size() >= 2 && asked.answer[0] >= 0x80) {
    ++report_.exceptions[hex(Bytes(asked.answer).subspan(1, 1))];
  } else {
    ++report_.answers;
  }
  witness_->answered(id);
}

}  // namespace mbgate::world
