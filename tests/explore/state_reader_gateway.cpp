// SPDX-License-Identifier: Apache-2.0
// The gateway: its clients and their requests.
#include "explore/require.hpp"
#include "explore/state_reader.hpp"

namespace mbgate {

void StateReader::read(gateway::Gateway& gateway, Hash& hash) {
  // Counted, told or shown only: own_unit, client_counters, unrouted_told, started. Only without
  // guards: writers, failsafe, failsafe_runs. Read with those that refer to them: exchanges, jobs.
  // Only with partial requests or idle timeouts: timers. Empty when the machine was asked for its
  // actions: dirty_buses, ready_clients, line_actions, actions. As many as there are clients:
  // listener_clients, sources, free_sources. Whatever arrives from now on is younger than all of
  // them: stop_marks.
  auto& [generations, own_unit, exchanges, jobs, buses, sessions, listener_clients, client_counters,
         sources, free_sources, timers, stop_marks, writers, failsafe, failsafe_runs, unrouted_told,
         dirty_buses, ready_clients, line_actions, actions, started, stopping, finished,
         stop_deadline] = gateway;
  explore::require(generations.size() == 1 && gateway.settings().guards.empty(),
                   "one snapshot of settings, and no guards");
  explore::require(!timers.next() && dirty_buses.empty() && ready_clients.empty(),
                   "nothing is left to do");
  hash.add(stopping);
  hash.add(finished);
  hash.add(stop_deadline.has_value());
  hash.add(sessions.size());
  for (std::uint64_t client = 1; client <= sessions.size(); ++client) {
    read(sessions.at(gateway::ClientId{client}), gateway, hash);
  }
  hash.add(exchanges.in_use());
  hash.add(jobs.in_use());
  for (const auto& slot : buses) {
    read(slot->bus, gateway, hash);
  }
}

void StateReader::read(const gateway::ClientSession& session, gateway::Gateway& gateway,
                       Hash& hash) {
  // Settings: info, listener, ordered, rights. Told only: speaks_rtu_reported, has_asked. Counts
  // for idle clients only: last_activity. Nothing is read ahead and no pipeline is full: ahead,
  // partial_since, timer_armed_at, held, first_held, pauses, and where in the stream it is:
  // position, read_position, unread.
  const auto& [input, ahead, has_asked, is_leaving, speaks_rtu_reported, last_activity,
               partial_since, timer_armed_at, exchanges, info, listener, ordered, rights, open,
               unsent, held, first_held, position, paused, half_closed, pauses, read_position,
               unread] = session;
  explore::require(input.empty() && !session.is_full() && held.empty() && pauses.empty() &&
                       !partial_since && !timer_armed_at && unread == 0,
                   "nothing is read ahead");
  explore::require(listener->idle_timeout == Duration{0}, "idle clients stay");
  hash.add(is_leaving);
  hash.add(open);
  hash.add(unsent);
  hash.add(paused);
  hash.add(half_closed);
  hash.add(exchanges.size());
  for (const std::uint32_t index : exchanges) {
    read(gateway.exchanges_[index], gateway, hash);
  }
}

void StateReader::read(const gateway::Exchange& exchange, gateway::Gateway& gateway, Hash& hash) {
  if (!hash.name(&exchange)) {
    return;
  }
  // One for all: generation, word_order, reply. Of its client: listener, address. Unordered answers
  // have no place: answer.
  const auto& [snapshot, client, listener, word_order, address, client_gone, is_stop, left_out,
               failsafe, answer, header, reply, plan, parts, response, failed, had_no_path,
               was_on_wire, wrong_word_order] = exchange;
  explore::require(plan && !failsafe && left_out.empty(), "a request of a client");
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
  const bus::DeviceTable& devices = gateway.buses_.front()->bus.devices_;
  for (const auto& [bus, job] : parts) {
    hash.add(bus);
    read(job, devices, gateway, hash);
  }
}

// A plan follows from the settings and the request alone, and without windows that is what is
// transmitted.
void StateReader::read(const routing::Plan& plan, Hash& hash) {
  hash.add(plan.is_read());
  hash.add(plan.function());
  for (const routing::PlannedTransaction& transaction : plan.transactions()) {
    hash.add(transaction.address);
    hash.add(transaction.request.pdu().bytes());
  }
}

}  // namespace mbgate
