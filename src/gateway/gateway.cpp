// SPDX-License-Identifier: Apache-2.0
#include "gateway/gateway.hpp"

#include "gateway/limits.hpp"

namespace mbgate::gateway {

Gateway::Gateway(Settings settings, Instant now)
    : settings_(std::move(settings)),
      exchanges_(settings_, buses_, actions_),
      buses_(settings_.settings()),
      rules_(settings_.in_force()),
      failsafe_(settings_, exchanges_, rules_, actions_),
      clients_(settings_, buses_, exchanges_, rules_, failsafe_, actions_, now) {
  settle(now);
}

void Gateway::handle_client_connected(ClientId client, const ClientInfo& info, Instant now) {
  clients_.connected(client, info, now);
  settle(now);  // whoever made room for it may have been the last that may write
}

void Gateway::handle_client_bytes(ClientId client, modbus::Bytes bytes, Instant now,
                                  std::size_t unread) {
  clients_.received(client, bytes, unread, now);
  settle(now);
}

void Gateway::handle_client_sent(ClientId client, Instant now) {
  clients_.sent(client, now);
  settle(now);
}

void Gateway::handle_client_half_closed(ClientId client, Instant now) {
  clients_.half_closed(client);
  settle(now);
}

void Gateway::handle_client_disconnected(ClientId client, Instant now) {
  clients_.disconnected(client, now);
  settle(now);
}

void Gateway::handle_bus_opened(BusId bus, Instant now, bus::LineKind kind) {
  bus::Bus& opened = buses_.touch(bus);
  if (!opened.is_open() && !opened.is_reopening()) {
    report(BusOpened{bus});
  }
  opened.handle_opened(now, kind);
  failsafe_.bus_opened(bus);
  settle(now);
}

void Gateway::handle_bus_bytes(BusId bus, modbus::Bytes bytes, Instant now) {
  buses_.touch(bus).handle_bytes(bytes, now);
  settle(now);
}

void Gateway::handle_bus_looked(BusId bus, Instant now) {
  buses_.touch(bus).handle_looked(now);
  settle(now);
}

void Gateway::handle_bus_lost(BusId bus, Instant now, bus::Loss loss) {
  bus::Bus& lost = buses_.touch(bus);
  const bool was_open = lost.is_open() || lost.is_reopening();
  lost.handle_lost(now, loss);
  if (was_open && !lost.is_open()) {
    report(BusLost{bus});
  }
  settle(now);
}

void Gateway::handle_deadline(Instant now) {
  buses_.handle_deadline(now);
  clients_.handle_deadline(now);
  if (stop_deadline_ && now >= *stop_deadline_) {
    stop_deadline_.reset();
    clients_.set_phase(Phase::nothing);
    buses_.give_up(now);
  }
  settle(now);
}

void Gateway::handle_shutdown(Instant now) {
  if (stopping_) {
    return;
  }
  stopping_ = true;
  stop_deadline_ = now + kShutdownGrace;
  buses_.stop(now);
  failsafe_.send_at_exit(now);
  clients_.set_phase(Phase::only_stops);
  settle(now);
}

void Gateway::handle_settings(Settings settings, Instant now) {
  if (stopping_) {
    return;
  }
  const SettingsDiff diff(settings_.settings(), settings);
  clients_.close_unwanted(settings, diff, now);
  const SettingsSnapshot& before = settings_.adopt(std::move(settings));
  exchanges_.end_changed(before, diff);
  exchanges_.renumber(diff);
  rules_.adopt(settings_.in_force(), diff);
  clients_.adopt(diff, now);
  failsafe_.adopt(before, diff, clients_.sessions(), now);
  adopt_buses(diff, now);
  settings_.forget_unused();
  settle(now);
}

void Gateway::adopt_buses(const SettingsDiff& diff, Instant now) {
  for (const BusSet::GivenUp& given_up : buses_.adopt(settings(), diff, now)) {
    // What was on the wire ends, and what waits. Nobody needs its news any more.
    given_up.bus->handle_lost(now);
    while (const auto action = given_up.bus->poll()) {
      if (const auto* ended = std::get_if<bus::JobEnded>(&*action)) {
        exchanges_.end(*ended->job, ended->ending);
      }
    }
    if (given_up.successor) {
      line_actions_.push(Shut{*given_up.successor});
    }
  }
}

std::optional<Action> Gateway::poll_action() {
  if (auto action = line_actions_.poll()) {
    return action;
  }
  return actions_.poll();
}

std::optional<Wake> Gateway::next_wake() const {
  auto judgement = bus::earlier(clients_.next_deadline(), stop_deadline_);
  if (!stopping_) {
    judgement = bus::earlier(judgement, failsafe_.next());
  }
  return buses_.next_wake(judgement);
}

Status Gateway::status() const { return {clients_.size(), buses_.open_count()}; }

// Everything that one input set off, until nothing is left. A list of work instead of recursion: an
// answer may free a place, which takes a request, which may be answered at once.
void Gateway::settle(Instant now) {
  while (settle_one(now)) {
  }
  clients_.sweep();
  if (stopping_ && !finished_ && !exchanges_.any_open()) {
    finished_ = true;
    stop_deadline_.reset();
    clients_.set_phase(Phase::nothing);
    actions_.push(Finished{});
  }
}

bool Gateway::settle_one(Instant now) {
  if (const auto exchange = exchanges_.take_completed()) {
    failsafe_.ended(*exchange);
    clients_.complete(*exchange);
    exchanges_.close(*exchange);
    return true;
  }
  if (const auto bus = buses_.take_touched()) {
    collect(*bus);
    return true;
  }
  return clients_.serve_one(now) || (!stopping_ && failsafe_.send_due(now));
}

void Gateway::collect(BusId bus) {
  while (const auto action = buses_.poll(bus)) {
    if (const auto* ended = std::get_if<bus::JobEnded>(&*action)) {
      exchanges_.end(*ended->job, ended->ending);
    } else {
      carry_out(bus, *action);
    }
  }
  failsafe_.note_sent();
}

void Gateway::carry_out(BusId bus, const bus::BusAction& action) {
  if (const auto* transmit = std::get_if<bus::TransmitFrame>(&action)) {
    line_actions_.push(Transmit{bus, transmit->frame});
  } else if (std::holds_alternative<bus::LookAtLine>(action)) {
    line_actions_.push(Look{bus});
  } else if (std::holds_alternative<bus::OpenLine>(action)) {
    line_actions_.push(Open{bus});
  } else if (std::holds_alternative<bus::CloseLine>(action)) {
    report(BusLost{bus});
    line_actions_.push(Shut{bus});
  } else if (const auto* reopen = std::get_if<bus::ReopenLine>(&action)) {
    if (reopen->first) {
      report(AdapterSilent{bus, reopen->silence, reopen->requests});
    }
    line_actions_.push(Shut{bus});
    line_actions_.push(Open{bus});
  } else if (const auto* replace = std::get_if<bus::ReplaceLine>(&action)) {
    if (replace->is_news) {
      report(ConnectionReplaced{bus});
    }
    line_actions_.push(Shut{bus});
  } else if (const auto* notice = std::get_if<bus::DeviceNotice>(&action)) {
    report(DeviceNews{bus, *notice});
  } else if (std::holds_alternative<bus::NeverSilent>(action)) {
    report(LineNeverSilent{bus});
  } else if (const auto* quality = std::get_if<bus::QualityNotice>(&action)) {
    report(QualityNews{bus, *quality});
  } else {
    report(LineNews{bus, std::get<bus::LineNotice>(action).fault});
  }
}

}  // namespace mbgate::gateway
