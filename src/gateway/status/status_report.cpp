// SPDX-License-Identifier: Apache-2.0
#include "gateway/status/status_report.hpp"

#include <algorithm>
#include <bitset>
#include <fmt/core.h>

namespace mbgate::gateway {
namespace {

std::string line_text(const bus::LineSettings& line) {
  return line.remote ? fmt::format("{}:{}", line.remote->host, line.remote->port) : line.device;
}

std::optional<Duration> since(Instant instant, Instant now) {
  return instant == Instant::min() ? std::nullopt : std::optional(now - instant);
}

std::optional<WaitingClient> most_waiting(const bus::Bus& bus, const Sessions& sessions,
                                          Instant now) {
  const auto most = bus.parts().most_waiting(now);
  const auto* address = most ? sessions.address_of(most->source) : nullptr;
  if (address == nullptr) {  // it may have gone: stops are sent all the same
    return std::nullopt;
  }
  const bool others_ask = std::ranges::any_of(sessions.open(), [&](const ClientSession& client) {
    return client.requests > 0 && client.turns->key != most->source;
  });
  return WaitingClient{address->to_text(), most->requests, most->of, now - most->since, others_ask};
}

BusStatus status_of(const bus::Bus& bus, Instant now) {
  const bus::BusSettings& settings = bus.parts().settings;
  const bus::LineSettings& line = settings.line;
  BusStatus status;
  status.name = settings.name;
  status.line = line_text(line);
  status.framing = line.framing;
  status.is_serial = !line.remote;
  status.baud = line.baud;
  status.format = line.format;
  if (line.framing != bus::Framing::tcp) {
    const modbus::RtuTiming timing(line.baud, line.format);
    status.character = timing.duration_of(1);
    status.frame_gap = settings.frame_gap.value_or(timing.t3_5());
  }
  status.is_open = bus.link().serves();
  status.is_starting = bus.link().is_starting();
  status.state = bus.parts().line.state(now);
  status.is_reopening = bus.link().is_reopening();
  status.load = bus.diagnosis().load().percent(now);
  status.waits = bus.diagnosis().load().waits(now);
  status.busy = bus.diagnosis().load().total(now);
  status.waiting = bus.parts().waiting();
  status.longest_waiting = bus.parts().queue.longest_wait(now);
  status.silences = bus.diagnosis().silences();
  status.silence = bus.parts().adapter.silence(now);
  status.counters = bus.counters();
  status.last_foreign = since(bus.diagnosis().last_foreign(), now);
  status.last_foreign_request = since(bus.diagnosis().last_foreign_request(), now);
  status.last_never_silent = since(bus.diagnosis().last_never_silent(), now);
  status.echo = bus.diagnosis().echo();
  status.quality = bus.diagnosis().quality().verdict();
  return status;
}

// Other settings may have come since it was read.
std::optional<OtherWordOrder> other_order(const bus::DeviceEntry& entry) {
  const drive::Device& device = *entry.device;
  const auto* stated = device.stated_order();
  if (!device.verify_word_order || stated == nullptr || !entry.setting ||
      std::ranges::find(*stated, *entry.setting) != stated->end()) {
    return std::nullopt;
  }
  return OtherWordOrder{device.profile.word_order_register->address, *entry.setting, *stated};
}

DeviceStatus status_of(const bus::Bus& bus, std::uint8_t address, Instant now) {
  const bus::DeviceEntry& entry = bus.devices()[address];
  DeviceStatus status;
  status.address = address;
  status.state = bus.parts().state_of(address);
  const auto passed = since(entry.health.state_since(), now);
  if (passed && status.state != DeviceStatus::State::line_not_open) {
    status.state_since = std::max(*passed, Duration{0});
  }
  status.has_answered = bus.diagnosis().quality()[address].has_answered();
  status.last_request = since(entry.asked_at, now);
  status.last_answer = since(entry.silence.last_answer(), now);
  status.unanswered_in_row = entry.health.unanswered_in_row();
  status.silence = entry.silence;
  if (status.silence.transmissions() > 0) {
    status.silent_for = std::max(now - entry.silence.began(), Duration{0});
  }
  status.held_back = bus.parts().held_back(address, now);
  status.quarantine = entry.hold.tail(now, entry.in_force());
  status.least_quarantine = entry.in_force().quarantine_or_default();
  if (entry.health.is_offline()) {
    status.next_probe = std::max(entry.probe_at - now, Duration{0});
  }
  status.response_timeout = entry.in_force().response_timeout;
  status.last_second_answer = since(
      bus.diagnosis().echo() == bus::NoticedEcho::none ? entry.second_at : entry.second_read_at,
      now);
  status.other_order = other_order(entry);
  status.unreached = entry.unreached;
  if (entry.failed_stop) {
    status.last_failed_stop = now - entry.failed_stop->at;
    status.stop_exception = entry.failed_stop->exception;
  }
  status.counters = entry.counters;
  status.quality = bus.diagnosis().quality()[address].verdict();
  status.times = entry.times;
  if (bus.parts().settings.line.remote) {  // on a connection nobody knows
    status.times.wire = {};
  }
  return status;
}

// Addresses of transparent listeners and routes without a device.
void add_unnamed(const bus::Bus& bus, std::size_t place, Instant now,
                 std::vector<DeviceStatus>& devices) {
  std::bitset<bus::kAddresses> named;
  for (const drive::Device& device : bus.devices().devices()) {
    named.set(device.address);
  }
  for (std::size_t address = 0; address < bus::kAddresses; ++address) {
    const auto number = static_cast<std::uint8_t>(address);
    if (!named[address] && bus.devices()[number].asked_at != Instant::min()) {
      devices.push_back(status_of(bus, number, now));
      devices.back().bus = place;
    }
  }
}

}  // namespace

StatusReport make_status_report(const StatusView& view, bool with_clients) {
  const Settings& settings = view.settings;
  const Instant now = view.now;
  StatusReport report;
  report.uptime = now - view.started;
  report.counters = view.counters;
  for (const BusId bus : view.buses) {
    report.buses.push_back(status_of(view.all[bus], now));
    report.buses.back().most_waiting = most_waiting(view.all[bus], view.sessions, now);
  }
  for (const auto& [device, place] : view.devices) {
    DeviceStatus status = status_of(view.all[device->bus], device->address, now);
    status.name = device->name;
    status.bus = place;
    report.devices.push_back(std::move(status));
  }
  for (std::size_t place = 0; place < view.buses.size(); ++place) {
    add_unnamed(view.all[view.buses[place]], place, now, report.devices);
  }
  for (std::size_t number = 0; number < settings.listeners.size(); ++number) {
    const auto listener = static_cast<ListenerId>(number);
    if (!settings.listener(listener).is_gone) {
      const ListenerCounters& counters = view.sessions.counters(listener);
      report.listeners.push_back({settings.listener(listener).name, view.sessions.on(listener),
                                  counters, since(counters.recent.failed_at, now)});
    }
  }
  if (with_clients) {
    for (const ClientSession& client : view.sessions.open()) {
      report.clients.push_back({client.info().address.to_text(),
                                settings.listener(client.info().listener).name, client.requests,
                                client.refused, client.answers.outstanding()});
    }
  }
  return report;
}

}  // namespace mbgate::gateway
