// SPDX-License-Identifier: Apache-2.0
// The doors of the machine for buses and time, and the loop that works off what an input set off.
#include "gateway/gateway.hpp"

#include <algorithm>

#include "gateway/limits.hpp"

namespace mbgate::gateway {
Gateway::Gateway(Settings settings, Instant now)
    : listener_clients_(settings.listeners.size()),
      stop_marks_(settings.devices.size()),
      writers_(settings.devices.size()),
      started_(now) {
  const Settings& given = snapshots_.emplace_back(std::move(settings)).settings;
  failsafe_ = current().new_failsafe();
  for (std::size_t index = 0; index < given.buses.size(); ++index) {
    const BusId id{static_cast<std::uint32_t>(index)};
    buses_.push_back(std::make_unique<BusSlot>(given.buses[index], given.devices_on(id)));
    touch(id).start();
  }
  settle(now);
}

void Gateway::handle_bus_opened(BusId bus, Instant now, bus::LineKind kind) {
  bus::Bus& opened = touch(bus);
  if (!opened.is_open() && !opened.is_reopening()) {
    report(BusOpened{bus});
  }
  opened.handle_opened(now, kind);
  for (std::size_t place = 0; place < settings().devices.size(); ++place) {
    if (settings().devices[place].bus == bus) {
      failsafe_.line_is_back(place);
    }
  }
  settle(now);
}

void Gateway::handle_bus_bytes(BusId bus, modbus::Bytes bytes, Instant now) {
  touch(bus).handle_bytes(bytes, now);
  settle(now);
}

void Gateway::handle_bus_looked(BusId bus, Instant now) {
  touch(bus).handle_looked(now);
  settle(now);
}

void Gateway::handle_bus_lost(BusId bus, Instant now, bus::Loss loss) {
  bus::Bus& lost = touch(bus);
  const bool was_open = lost.is_open() || lost.is_reopening();
  lost.handle_lost(now, loss);
  if (was_open && !lost.is_open()) {
    report(BusLost{bus});
  }
  settle(now);
}

void Gateway::handle_deadline(Instant now) {
  for (std::size_t index = 0; index < buses_.size(); ++index) {
    const auto wake = buses_[index]->bus.next_wake();
    if (wake && wake->at <= now) {
      touch(BusId{static_cast<std::uint32_t>(index)}).handle_deadline(now);
    }
  }
  while (const auto due = timers_.take_due(now)) {
    check_client(*due, now);
  }
  if (stop_deadline_ && now >= *stop_deadline_) {
    stop_deadline_.reset();
    for (std::size_t index = 0; index < buses_.size(); ++index) {
      touch(BusId{static_cast<std::uint32_t>(index)}).give_up(now);
    }
  }
  settle(now);
}

void Gateway::handle_shutdown(Instant now) {
  if (stopping_) {
    return;
  }
  stopping_ = true;
  stop_deadline_ = now + kShutdownGrace;
  for (std::size_t index = 0; index < buses_.size(); ++index) {
    touch(BusId{static_cast<std::uint32_t>(index)}).stop(now);
  }
  take_failsafe_at_exit(now);
  for (const auto& [client, session] : sessions_) {
    ready_clients_.push_back(client);
  }
  settle(now);
}

std::optional<Action> Gateway::poll_action() {
  if (auto action = line_actions_.poll()) {
    return action;
  }
  return actions_.poll();
}

std::optional<Wake> Gateway::next_wake() const {
  auto judgement = bus::earlier(timers_.next(), stop_deadline_);
  if (!stopping_) {
    judgement = bus::earlier(judgement, failsafe_.next());
  }
  auto first = judgement ? std::optional(bus::Wake{*judgement}) : std::nullopt;
  std::uint32_t of = 0;
  for (std::uint32_t index = 0; index < buses_.size(); ++index) {
    const auto wake = buses_[index]->bus.next_wake();
    of = wake && (!first || wake->at < first->at) ? index : of;
    first = bus::earlier(first, wake);
  }
  if (!first) {
    return std::nullopt;
  }
  return Wake{first->at, first->ends_silence ? std::optional(BusId{of}) : std::nullopt};
}

Status Gateway::status() const {
  const auto open =
      std::ranges::count_if(buses_, [](const auto& slot) { return slot->bus.is_open(); });
  return {sessions_.size(), static_cast<std::size_t>(open)};
}

bus::Bus& Gateway::touch(BusId id) {
  BusSlot& slot = *buses_[static_cast<std::size_t>(id)];
  if (!slot.dirty) {
    slot.dirty = true;
    dirty_buses_.push_back(id);
  }
  return slot.bus;
}

// Everything that one input set off, until nothing is left. A list of work instead of recursion: an
// answer may free a place, which takes a request, which may be answered at once.
void Gateway::settle(Instant now) {
  for (;;) {
    if (!dirty_buses_.empty()) {
      const BusId bus = dirty_buses_.back();
      dirty_buses_.pop_back();
      collect(bus);
      continue;
    }
    if (!ready_clients_.empty()) {
      const ClientId client = ready_clients_.back();
      ready_clients_.pop_back();
      if (const auto entry = sessions_.find(client); entry != sessions_.end()) {
        after_input(client, entry->second, now);
      }
      continue;
    }
    auto due = stopping_ ? std::nullopt : failsafe_.take_due(now);
    if (!due) {
      break;
    }
    send_failsafe(*std::move(due), now);
  }
  finish_if_stopped();
}

void Gateway::collect(BusId id) {
  BusSlot& slot = *buses_[static_cast<std::size_t>(id)];
  slot.dirty = false;
  while (auto action = slot.bus.poll()) {
    if (const auto* ended = std::get_if<bus::JobEnded>(&*action)) {
      end_part(*ended->job, ended->ending);
    } else if (const auto* transmit = std::get_if<bus::TransmitFrame>(&*action)) {
      line_actions_.push(Transmit{id, transmit->frame});
    } else if (std::holds_alternative<bus::LookAtLine>(*action)) {
      line_actions_.push(Look{id});
    } else if (std::holds_alternative<bus::OpenLine>(*action)) {
      line_actions_.push(Open{id});
    } else if (std::holds_alternative<bus::CloseLine>(*action)) {
      report(BusLost{id});
      line_actions_.push(Shut{id});
    } else if (const auto* reopen = std::get_if<bus::ReopenLine>(&*action)) {
      if (reopen->first) {
        report(AdapterSilent{id, reopen->silence, reopen->requests});
      }
      line_actions_.push(Shut{id});
      line_actions_.push(Open{id});
    } else if (const auto* replace = std::get_if<bus::ReplaceLine>(&*action)) {
      if (replace->is_news) {
        report(ConnectionReplaced{id});
      }
      line_actions_.push(Shut{id});
    } else if (const auto* notice = std::get_if<bus::DeviceNotice>(&*action)) {
      report(DeviceNews{id, *notice});
    } else if (std::holds_alternative<bus::NeverSilent>(*action)) {
      report(LineNeverSilent{id});
    } else if (const auto* quality = std::get_if<bus::QualityNotice>(&*action)) {
      report(QualityNews{id, *quality});
    } else {
      report(LineNews{id, std::get<bus::LineNotice>(*action).fault});
    }
  }
  note_failsafe_sent();
}

void Gateway::finish_if_stopped() {
  if (stopping_ && !finished_ && exchanges_.in_use() == 0) {
    finished_ = true;
    stop_deadline_.reset();
    actions_.push(Finished{});
  }
}

}  // namespace mbgate::gateway
