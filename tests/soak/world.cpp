// SPDX-License-Identifier: Apache-2.0
#include "soak/world.hpp"

#include <algorithm>
#include <cstdio>
#include <deque>
#include <utility>

namespace mbgate::soak {

using namespace std::chrono_literals;

namespace {

constexpr Duration kLongestRun = std::chrono::hours(20);
constexpr std::uint64_t kMostRequests = 100;  // for each transmission that is to be seen
// A gateway that is well does a few thousand things in so short a time, however many clients it
// has.
constexpr Duration kPlace = 10ms;
constexpr unsigned kMostInPlace = 200'000;
constexpr const char* kEndlessActions = "the gateway's actions have no end";
constexpr std::uint64_t kDriversChance = 0x445249564552ULL;  // apart from the plant's
constexpr std::uint64_t kSwapsChance = 0x535741505050ULL;
constexpr std::uint64_t kRestartsChance = 0x5245535441525453ULL;

}  // namespace

Oracle::Devices World::make_devices(const SoakPlan& plan, Random& random) {
  Oracle::Devices devices;
  for (std::size_t at = 0; at < plan.settings.devices.size(); ++at) {
    devices.emplace_back(plan.settings.devices[at], plan.own_orders[at],
                         random.below(~std::uint64_t{0}));
  }
  return devices;
}

World::World(std::uint64_t seed, bool trace)
    : random_(seed),
      swaps_(seed ^ kSwapsChance),
      restarts_(seed ^ kRestartsChance),
      plan_(draw_plan(random_, seed)),
      devices_(make_devices(plan_, random_)),
      oracle_(plan_, devices_, schedule_, report_),
      asking_(plan_, random_),
      around_{plan_,
              schedule_,
              random_,
              report_,
              oracle_,
              devices_,
              [this](std::size_t bus, const auto& bytes) { deliver(bus, bytes); },
              [this](std::size_t bus, bool answered) { hang_up(bus, answered); },
              [this](std::size_t bus) { buses_[bus].framing_lost = true; }},
      buses_(plan_.settings.buses.size()),
      hangs_(plan_),
      reloads_(plan_, devices_, oracle_, seed),
      harness_(plan_.settings, schedule_.now()),
      driver_(plan_.driver, buses_.size(), seed ^ kDriversChance, schedule_, hands()),
      tools_{harness_,
             driver_,
             oracle_,
             schedule_,
             random_,
             report_,
             asking_,
             [this] { drain(); },
             [this] { return ClientId{++last_number_}; },
             [this](std::size_t it) {
               return plan_.absent.listeners[it]
                          ? std::nullopt
                          : std::optional(gateway::ListenerId{static_cast<std::uint32_t>(it)});
             },
             plan_,
             plan_.settings,
             clients_,
             full_,
             is_stopping_},
      trace_(trace) {
  if (trace) {
    oracle_.trace();
  }
  for (std::size_t bus = 0; bus < buses_.size(); ++bus) {
    if (plan_.settings.buses[bus].line.framing == bus::Framing::tcp) {
      wires_.emplace_back(std::in_place_type<FarServer>, bus, around_);
    } else {
      wires_.emplace_back(std::in_place_type<SerialWire>, bus, around_);
    }
    std::visit([](auto& wire) { wire.begin_trouble(); }, wires_.back());
    begin_losses(bus);
  }
  for (const Manners& manners : plan_.clients) {
    clients_.emplace_back(manners, tools_).begin();
  }
  check_overdue_often();
  clear_counters_some_time();
  begin_reloads();
  begin_restarts();
  drain();
}

Report World::run(std::uint64_t transmissions) {
  const Instant begun = schedule_.now();
  const std::uint64_t requests = kMostRequests * transmissions;
  while (report_.transmissions < transmissions && report_.requests < requests &&
         schedule_.now() < begun + kLongestRun) {
    if (!step()) {
      break;
    }
  }
  if (!plan_.stops_early) {
    come_to_rest();
  }
  if (!stuck_) {  // what it leaves undone then is no news
    shut_down();
  }
  report_.virtual_time = schedule_.now() - begun;
  return report_;
}

void World::check_overdue_often() {
  schedule_.after(1s, [this] {
    oracle_.check_overdue();
    check_overdue_often();
  });
}

Driver::Hands World::hands() {
  return {[this](std::size_t bus, Bytes bytes) { hand_in(bus, bytes); },
          [this](std::size_t bus) { lost(bus); },
          [this] {
            oracle_.deadline_handed_in();
            harness_.handle(gateway::DeadlineReached{}, schedule_.now());
            drain();
          },
          [this](Duration missed) { stalled(missed); },
          [this] {
            const auto wake = harness_.next_wake();
            return wake ? std::optional(bus::Wake{wake->at, wake->silence_of.has_value()})
                        : std::nullopt;
          },
          [this](Duration time) { interrupt(time); },
          [this](const char* kind) { report_.fault(kind); }};
}

// False: it does one thing after the other and time does not go on. Nothing more is asked of it
// then: everything that waits for time to pass would wait for ever.
bool World::makes_progress(const char* busy_with) {
  if (schedule_.now() > place_ + kPlace) {
    place_ = schedule_.now();
    done_in_place_ = 0;
  }
  if (!stuck_ && ++done_in_place_ > kMostInPlace) {
    stuck_ = true;
    oracle_.violation("no_progress", busy_with);
  }
  return !stuck_;
}

bool World::step() {
  const auto wakes = driver_.wakes_at();
  const auto next = bus::earlier(schedule_.next(), wakes);
  if (!next || !makes_progress("the gateway's deadline stays in the past")) {
    return false;
  }
  schedule_.advance(*next);
  if (wakes == next) {
    driver_.wake();
    oracle_.check_waiting();
  } else {
    schedule_.run_one();
  }
  return true;
}

void World::interrupt(Duration time) {
  const Instant end = schedule_.now() + time;
  for (auto next = schedule_.next();
       next && *next <= end && makes_progress("the plant does not come to rest");
       next = schedule_.next()) {
    schedule_.advance(*next);
    schedule_.run_one();
  }
  schedule_.advance(end);
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

// Actions that set off others (a client that is resumed writes on) come back here; the outer call
// goes on with them. All of it is one instant. The gateway wants frames transmitted before answers
// are sent; the oracle is told of them after the answers that made way for them, but at the end of
// a gateway that stops before what is said of them: that nobody has answered in time.
void World::drain() {
  if (draining_ || stuck_) {
    return;
  }
  draining_ = true;
  carried_out_ = 0;
  const auto take_one = [this](const gateway::Action& action) { return take(action); };
  while (harness_.drain(take_one) && !frames_.empty() && makes_progress(kEndlessActions)) {
    const gateway::Action frame = std::move(frames_.front());
    frames_.pop_front();
    carry_out(frame);
  }
  draining_ = false;
  if (!driver_.is_awake()) {
    driver_.set_timer();
    oracle_.check_waiting();
  }
}

bool World::take(const gateway::Action& action) {
  if (!makes_progress(kEndlessActions)) {
    return false;
  }
  if (std::holds_alternative<gateway::Transmit>(action) && schedule_.now() < end_) {
    frames_.push_back(action);
  } else {
    carry_out(action);
  }
  return true;
}

void World::trace(const std::string& text) const {
  if (trace_) {
    std::fprintf(stderr, "%lld %s\n",
                 static_cast<long long>(schedule_.now().time_since_epoch().count() / 1000),
                 text.c_str());
  }
}

void World::carry_out(const gateway::Action& action) {
  ++carried_out_;
  if (trace_) {
    trace(gateway::to_text(action, harness_.settings()));
  }
  const auto bus_of = [](gateway::BusId bus) { return static_cast<std::size_t>(bus); };
  check_order_only(action);
  if (const auto* send = std::get_if<gateway::Send>(&action)) {
    if (Client* client = find(send->client)) {
      client->take({send->adu.data(), send->adu.size()});
    } else if (!close_due_.contains(send->client)) {
      oracle_.violation("answer_to_nobody", "an answer for a client that has gone");
    }
  } else if (const auto* transmit_frame = std::get_if<gateway::Transmit>(&action)) {
    transmit(bus_of(transmit_frame->bus),
             {transmit_frame->frame.data(), transmit_frame->frame.size()});
  } else if (const auto* report = std::get_if<gateway::Report>(&action)) {
    check_report(report->event);
  } else if (const auto* look = std::get_if<gateway::Look>(&action)) {
    driver_.look(static_cast<std::size_t>(bus_of(look->bus)), carried_out_ == 1);
    harness_.handle(gateway::LineLooked{look->bus}, schedule_.now());
  } else if (const auto* open_line = std::get_if<gateway::Open>(&action)) {
    open(bus_of(open_line->bus));
  } else if (const auto* shut_line = std::get_if<gateway::Shut>(&action)) {
    shut(bus_of(shut_line->bus));
  } else if (const auto* pause = std::get_if<gateway::Pause>(&action)) {
    if (Client* client = find(pause->client)) {
      client->pause();
    }
  } else if (const auto* resume = std::get_if<gateway::Resume>(&action)) {
    if (Client* client = find(resume->client)) {
      client->resume();
    }
  } else if (std::holds_alternative<gateway::Finished>(action)) {
    oracle_.finished();
  } else if (const auto* close = std::get_if<gateway::Close>(&action)) {
    if (Client* client = find(close->client)) {
      client->closed_by_gateway();
    } else {
      close_due_.erase(close->client);
    }
  }
}

Client* World::find(ClientId number) {
  const auto found = std::ranges::find_if(clients_, [&](const Client& client) {
    return client.is_connected() && client.number() == number;
  });
  return found == clients_.end() ? nullptr : &*found;
}

}  // namespace mbgate::soak
