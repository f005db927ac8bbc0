// SPDX-License-Identifier: Apache-2.0
// The gateway: its clients and their requests.
#include "explore/state_reader.hpp"
#include "explore/state_reader_parts.hpp"

namespace mbgate::explore {

void read_state(gateway::Gateway& gateway, StateHash& hash) { StateReader::read(gateway, hash); }

void StateReader::read(gateway::Gateway& gateway, Hash& hash) {
  // Empty when the machine was asked for its actions: actions. Looks only: trace.
  auto& [actions, settings, trace, exchanges, buses, rules, failsafe, lines, clients, stopping,
         finished, stop_deadline] = gateway;
  // Parts of the gateway, and what is empty as actions is: line_actions.
  [[maybe_unused]] auto& [line_buses, line_exchanges, line_trace, line_reports, line_actions] =
      lines;
  const auto& [snapshots] = settings;
  require(snapshots.size() == 1 && gateway.settings().guards.empty(),
          "one snapshot of settings, and no guards");
  require(gateway.settings().rules.empty(), "no access rules");
  hash.add(stopping);
  hash.add(finished);
  hash.add(stop_deadline.has_value());
  read(clients, gateway, hash);
  // Its requests and jobs are read with those that refer to them; the others belong to the gateway.
  // There is room for all of their transactions: planned.
  auto& [of_settings, of_buses, of_actions, requests, jobs, completed, planned] = exchanges;
  require(!completed.poll(), "nothing is left to do");
  hash.add(requests.in_use());
  hash.add(jobs.in_use());
  // Whatever arrives from now on is younger than all stops: known, sequence. Only without guards:
  // writers, and all of failsafe.
  [[maybe_unused]] auto& [in_force, known, sequence] = rules;
  // For the trace: traced.
  auto& [slots, touched, traced] = buses;
  require(touched.empty(), "nothing is left to do");
  for (const auto& slot : slots) {
    read(*slot.bus, gateway, hash);
  }
}

void StateReader::read(gateway::Clients& clients, gateway::Gateway& gateway, Hash& hash) {
  // The gateway's: settings, exchanges, failsafe, actions. Of the requests there are only counters
  // beyond these. Clients come at the start only, and may ask as often as they like: limits. Told
  // only: logins, over_rate.
  [[maybe_unused]] auto& [settings, exchanges, failsafe, actions, sessions, intake, requests,
                          limits, logins, over_rate] = clients;
  // Of the intake: the phase is as far as the gateway has come; counted or told only: counters,
  // denials, unrouted_reported. Dealt with: request. The same settings all the time: changed_at.
  // No rules: access.
  [[maybe_unused]] auto& [of_settings, of_rules, of_actions, phase, request, counters, access,
                          denials, unrouted_reported, changed_at] = intake;
  require(changed_at.empty(), "the settings stay the same");
  // Only with partial requests or idle timeouts: timers. As many as there are clients: addresses,
  // free_keys. Counted only: of_listeners.
  auto& [in_force, by_number, closed, ready, timers, of_listeners, addresses, free_keys] = sessions;
  require(closed.empty() && ready.empty() && timers.empty(), "nothing is left to do");
  hash.add(by_number.size());
  for (std::uint64_t client = 1; client <= by_number.size(); ++client) {
    read(by_number.at(gateway::ClientId{client}), gateway, hash);
  }
}

void StateReader::read(const gateway::ClientSession& session, gateway::Gateway& gateway,
                       Hash& hash) {
  // Settings: id, info, key, listener, rights, turns. Told only: speaks_rtu_reported, has_asked,
  // requests, refused. Counts for idle clients only: last_activity. Everything was read and went on
  // to the bus: partial_since, timer_at, held_requests, waits_since, ran_at.
  const auto& [input, answers, has_asked, is_closed, is_leaving, speaks_rtu_reported, requests,
               refused, last_activity, partial_since, timer_at, turns, exchanges, held_requests, id,
               info, key, listener, rights, paused, half_closed, waits_since, ran_at] = session;
  // Settings: ordered. Not ordered: first_held.
  const auto& [ordered, open, unsent, held, first_held] = answers;
  require(input.empty() && !session.is_full() && held.empty() && held_requests.empty() &&
              !waits_since && !partial_since && timer_at == Instant::max(),
          "everything was read and went on to the bus");
  require(listener->idle_timeout == Duration{0}, "idle clients stay");
  require(!is_closed, "closed clients are gone");
  hash.add(is_leaving);
  hash.add(open);
  hash.add(unsent);
  hash.add(paused);
  hash.add(half_closed);
  hash.add(exchanges.size());
  for (const std::uint32_t index : exchanges) {
    read(gateway.exchanges_.exchanges_[index], gateway, hash);
  }
}

void StateReader::read(const gateway::Exchange& exchange, gateway::Gateway& gateway, Hash& hash) {
  if (!hash.name(&exchange)) {
    return;
  }
  // One for all: snapshot; of that and the unit: route. Of its client: listener, address. Unordered
  // answers have no place: answer. For the trace: ended_as.
  // Whatever is asked from now on has a later number: arrival, sequence.
  const auto& [snapshot, route, client, listener, address, client_gone, arrival, deadline, sequence,
               is_stop, is_held, is_replaced, answer, header, plan, parts, response, failed,
               was_on_wire, wrong_word_order, had_no_path, ended_as] = exchange;
  require(plan && !is_held && !is_replaced, "a request of a client that is on the bus");
  hash.add(client);
  hash.add(header.transaction);
  hash.add(header.unit);
  for (const bool flag :
       {client_gone, is_stop, failed, had_no_path, was_on_wire, wrong_word_order}) {
    hash.add(flag);
  }
  hash.add(response.has_value());
  if (response) {
    hash.add(response->bytes());
  }
  read(*plan, hash);
  hash.add(parts.size());
  for (const auto& [bus, job] : parts) {
    hash.add(bus);
    read(job, gateway, hash);
  }
}

// A plan follows from the settings and the request alone, and without windows that is what is
// transmitted.
void StateReader::read(const routing::Plan& plan, Hash& hash) {
  hash.add(plan.is_read());
  hash.add(plan.function());
  for (const drive::Transaction& transaction : plan.transactions()) {
    hash.add(transaction.address);
    hash.add(transaction.unit);
    hash.add(transaction.request.pdu().bytes());
  }
}

}  // namespace mbgate::explore
