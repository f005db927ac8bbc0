// SPDX-License-Identifier: Apache-2.0
#include "gateway/writes/failsafe_writes.hpp"

#include <algorithm>
#include <utility>

#include "gateway/settings/numbering.hpp"

namespace mbgate::gateway {
namespace {

bool same_failsafe(const SettingsSnapshot& old, const SettingsSnapshot& next, std::size_t device) {
  return std::ranges::equal(old.failsafe(device), next.failsafe(device), {}, &modbus::Request::pdu,
                            &modbus::Request::pdu);
}

}  // namespace

void FailsafeWrites::client_came(const ClientSession& client) {
  watch_.client_came(client.id(), settings_.in_force().watched_for(client.info(), client.rights()));
}

void FailsafeWrites::client_asked(ClientId client, Instant now) {
  for (const std::size_t device : watch_.client_asked(client, now)) {
    report(Failsafe::Due{device, FailsafeReason::gone}, FailsafeOutcome::client_back);
  }
}

void FailsafeWrites::bus_opened(BusId bus) {
  const auto& devices = settings_.settings().devices;
  for (std::size_t place = 0; place < devices.size(); ++place) {
    if (devices[place].bus == bus) {
      watch_.line_is_back(place);
    }
  }
}

bool FailsafeWrites::send_due(Instant now) {
  auto due = watch_.take_due(now);
  if (!due) {
    return false;
  }
  send(*std::move(due), now);
  return true;
}

// Each is a request of its own, because a stop is repeated and another write is not. The bus is
// asked even if its line is away: it may be one that is opened on demand.
void FailsafeWrites::send(Failsafe::Due due, Instant now) {
  const drive::Device& device = settings_.settings().devices[due.device];
  rules_.note_own_stop(due.device, now);
  Run run{std::move(due), device.bus, device.address};
  const auto writes = settings_.in_force().failsafe(run.due.device);
  for (std::size_t place = 0; place < writes.size(); ++place) {
    if (std::ranges::find(run.due.sent, place) != run.due.sent.end()) {
      continue;
    }
    const std::uint32_t index = exchanges_.open();
    exchanges_[index].client_gone = true;
    bus::Job& job = exchanges_.add_job(index, device.bus, {}, now);
    job.job_class = bus::JobClass::stop;
    job.transactions.emplace_back(device.address, writes[place]);
    run.unsent.push_back({index, place});
    run.exchanges.push_back(index);
  }
  runs_.push_back(run);
  for (const std::uint32_t index : run.exchanges) {
    exchanges_.submit(index, now);
  }
}

void FailsafeWrites::note_sent() {
  for (Run& run : runs_) {
    note_sent(run);
  }
}

void FailsafeWrites::note_sent(Run& run) {
  if (run.unsent.empty()) {
    return;  // said already
  }
  std::erase_if(run.unsent, [&](const Write& write) {
    const bool was_sent = write.exchange && exchanges_[*write.exchange].has_been_on_wire();
    if (was_sent) {
      run.due.sent.push_back(write.place);
    }
    return was_sent;
  });
  if (run.unsent.empty()) {
    report(run, FailsafeOutcome::sent);
  }
}

void FailsafeWrites::ended(std::uint32_t exchange) {
  const auto run = std::ranges::find_if(runs_, [&](const Run& it) {
    return std::ranges::find(it.exchanges, exchange) != it.exchanges.end();
  });
  if (run == runs_.end()) {
    return;
  }
  note_sent(*run);
  for (Write& write : run->unsent) {
    write.exchange = write.exchange == exchange ? std::nullopt : write.exchange;
  }
  std::erase(run->exchanges, exchange);
  if (run->exchanges.empty()) {
    const Run ended = std::move(*run);
    runs_.erase(run);
    end(ended);
  }
}

bool FailsafeWrites::is_at_its_place(const Run& run) const {
  const drive::Device& device = settings_.settings().devices[run.due.device];
  return device.bus == run.bus && device.address == run.address;
}

void FailsafeWrites::end(const Run& run) {
  if (run.unsent.empty()) {
    return;
  }
  Failsafe::Due due = run.due;
  if (run.is_outdated) {
    due.sent.clear();
  }
  const bool was_told = std::exchange(due.told, true);
  if (stopping_) {
    report(run, FailsafeOutcome::given_up);
  } else if (!is_at_its_place(run)) {
    report(run, FailsafeOutcome::device_gone);
  } else if (!watch_.put_back(due)) {
    report(run, FailsafeOutcome::client_back);
  } else if (!was_told) {
    report(run, FailsafeOutcome::waits);
  }
}

void FailsafeWrites::send_at_exit(Instant now) {
  stopping_ = true;
  for (std::size_t place = 0; place < settings_.settings().devices.size(); ++place) {
    auto due = watch_.take_last(place, FailsafeReason::exit);
    if (!due) {
      continue;
    }
    if (settings_.in_force().guard(place)->failsafe_on_exit) {
      send(*std::move(due), now);
    } else if (due->told) {
      report(*due, FailsafeOutcome::given_up);
    }
  }
}

void FailsafeWrites::send_to_leaving(const Settings& next, Instant now) {
  const Settings& in_force = settings_.settings();
  for (std::size_t device = 0; device < in_force.devices.size(); ++device) {
    if (!keeps_place(in_force, next, device)) {
      if (auto due = watch_.take_last(device, FailsafeReason::leaves)) {
        send(*std::move(due), now);
      }
    }
  }
}

void FailsafeWrites::adopt(const SettingsSnapshot& before, const Sessions& clients, Instant now) {
  const SettingsSnapshot& next = settings_.in_force();
  const Failsafe old_watch = std::exchange(watch_, next.new_failsafe());
  clients.for_each([&](const ClientSession& client) {
    client_came(client);
    if (client.has_asked) {
      watch_.client_asked(client.id(), now);
    }
    // Its answers may have come of this reload: its silence begins then.
    watch_.client_waits(client.id(), client.waits, now);
  });
  for (std::size_t device = 0; device < before.settings.devices.size(); ++device) {
    if (keeps_place(before.settings, next.settings, device)) {
      watch_.carry(device, old_watch, same_failsafe(before, next, device));
    }
  }
  std::erase_if(runs_, [&](const Run& run) {
    return next.failsafe(run.due.device).empty() &&  // nobody asks any more
           keeps_place(before.settings, next.settings, run.due.device);
  });
  for (Run& run : runs_) {
    run.is_outdated = run.is_outdated || !same_failsafe(before, next, run.due.device);
  }
}

void FailsafeWrites::report(const Run& run, FailsafeOutcome outcome) {
  actions_.push(Report{FailsafeNews{run.bus, run.address, run.due.reason, outcome}});
}

void FailsafeWrites::report(const Failsafe::Due& due, FailsafeOutcome outcome) {
  const drive::Device& device = settings_.settings().devices[due.device];
  actions_.push(Report{FailsafeNews{device.bus, device.address, due.reason, outcome}});
}

}  // namespace mbgate::gateway
