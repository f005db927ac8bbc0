// SPDX-License-Identifier: Apache-2.0
#include "gateway/gateway.hpp"

#include "base/assert.hpp"
#include "gateway/limits.hpp"
#include "gateway/settings/settings_snapshot.hpp"

namespace mbgate::gateway {

Gateway::Gateway(Settings settings, Instant now)
    : settings_(std::move(settings)),
      exchanges_(settings_, buses_, actions_),
      buses_(settings_.settings()),
      rules_(settings_.in_force()),
      failsafe_(settings_, exchanges_, rules_, actions_),
      lines_(buses_, exchanges_, trace_, actions_),
      clients_(settings_, buses_, exchanges_, rules_, failsafe_, trace_, actions_, now) {
  settle(now);
}

void Gateway::handle(const Input& input, Instant now) {
  std::visit(
      [&](const auto& what) {
        if constexpr (requires { what.bus; }) {
          if (buses_.is_there(what.bus)) {  // no reload took the line away
            lines_.handle(what, now);
          }
        } else if constexpr (requires { what.client; }) {
          clients_.handle(what, now);
        } else {
          on(what, now);
        }
      },
      input);
  settle(now);
}

void Gateway::on(const DeadlineReached& /*input*/, Instant now) {
  buses_.handle_deadline(now);
  clients_.handle_deadline(now);
  if (stop_deadline_ && now >= *stop_deadline_) {
    clients_.set_phase(Phase::nothing);
    buses_.touch_all([now](bus::Bus& it) { it.give_up(now); });
  }
}

void Gateway::on(const Stalled& input, Instant now) {
  clients_.stalled(now - input.lasted);
  failsafe_.stalled(now);
}

void Gateway::on(const ClearCountersAsked& /*input*/, Instant /*now*/) {
  clients_.clear_counters();
}

void Gateway::on(const ShutdownAsked& /*input*/, Instant now) {
  if (stopping_) {
    return;
  }
  stopping_ = true;
  stop_deadline_ = now + kShutdownGrace;
  buses_.touch_all([now](bus::Bus& it) { it.stop(now); });
  failsafe_.send_at_exit(now);
  clients_.set_phase(Phase::only_stops);
}

void Gateway::on(const SettingsChanged& input, Instant now) {
  MBGATE_ASSERT(actions_.empty() && !lines_.has_actions(),
                "what older settings have decided is carried out before newer ones");
  if (stopping_) {
    return;
  }
  Settings next = numbered_after(settings(), *input.settings);
  clients_.close_unwanted(next, now);
  const SettingsSnapshot& before = settings_.adopt(std::move(next));
  exchanges_.end_changed(before);
  rules_.adopt(settings_.in_force());
  clients_.adopt(before, now);
  failsafe_.adopt(before);
  lines_.adopt(before.settings, settings(), now);
  settings_.forget_unused();
}

std::optional<Action> Gateway::poll_action() {
  return lines_.has_actions() ? lines_.poll_action() : actions_.poll();
}

std::optional<Wake> Gateway::next_wake() const {
  auto judgement = bus::earlier(clients_.sessions().next_look(), stop_deadline_);
  if (!stopping_) {
    judgement = bus::earlier(judgement, failsafe_.next());
  }
  return buses_.next_wake(judgement);
}

void Gateway::set_traced(bool traced) {
  trace_.set_on(traced);
  if (traced) {
    buses_.for_each([this](BusId id, const bus::Bus& it) {
      trace_.begin_amid(id, it.parts().transmissions.in_flight());
    });
  }
  buses_.set_traced(traced);
}

bool Gateway::meets_deadlines(Instant now) const {
  const auto wake = next_wake();
  return !wake || now - wake->at <= kOverdue;
}

StatusReport Gateway::report_status(Duration uptime, Instant now, bool with_clients) const {
  return make_status_report(
      {settings(), buses_, clients_.sessions(), clients_.counters(), now - uptime, now},
      with_clients);
}

// Everything that one input set off, until nothing is left. A list of work instead of recursion: an
// answer may free a place, which takes a request, which may be answered at once.
void Gateway::settle(Instant now) {
  while (settle_one(now)) {
  }
  clients_.sweep();
  if (stopping_ && !finished_ && exchanges_.open_count() == 0) {
    finished_ = true;
    stop_deadline_.reset();
    clients_.set_phase(Phase::nothing);
    actions_.push(Finished{});
  }
}

bool Gateway::settle_one(Instant now) {
  if (const auto exchange = exchanges_.take_completed()) {
    failsafe_.ended(*exchange, now);
    clients_.complete(*exchange, now);
    exchanges_.close(*exchange);
    return true;
  }
  return lines_.serve_one(now) || clients_.serve_one(now) ||
         (!stopping_ && failsafe_.send_due(now));
}

}  // namespace mbgate::gateway
