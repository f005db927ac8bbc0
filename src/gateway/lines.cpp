// SPDX-License-Identifier: Apache-2.0
#include "gateway/lines.hpp"

#include <variant>

namespace mbgate::gateway {

void Lines::handle(const LineOpened& input, Instant now) {
  bus::Bus& opened = buses_.touch(input.bus);
  if (trace_.is_on()) {
    trace_.opened(input.bus, now);
  }
  if (!opened.link().serves() && !opened.link().is_reopening()) {
    report(BusOpened{input.bus});
  }
  opened.handle_opened(now, input.kind);
}

void Lines::handle(const LineBytes& input, Instant now) {
  if (trace_.is_on()) {
    trace_.heard(input.bus, input.bytes, now);
  }
  buses_.touch(input.bus).handle_bytes(input.bytes, now);
}

void Lines::handle(const LineUnsent& input, Instant /*now*/) {
  buses_.touch(input.bus).note_unsent(input.bytes);
}

void Lines::handle(const LineLooked& input, Instant now) {
  buses_.touch(input.bus).handle_looked(now);
}

void Lines::handle(const LineLost& input, Instant now) {
  bus::Bus& lost = buses_.touch(input.bus);
  const bool was_open = lost.link().serves() || lost.link().is_reopening();
  lost.handle_lost(now, input.loss);
  if (was_open && !lost.link().serves()) {
    report(BusLost{input.bus});
  }
}

void Lines::serve(BusId bus, Instant now) {
  while (const auto action = buses_.poll(bus)) {
    if (trace_.is_on()) {
      trace_.acted(bus, *action, now);
    }
    if (const auto* ended = std::get_if<bus::JobEnded>(&*action)) {
      exchanges_.end(*ended->job, ended->ending);
    } else {
      carry_out(bus, *action);
    }
  }
}

void Lines::carry_out(BusId bus, const bus::BusAction& action) {
  if (const auto* transmit = std::get_if<bus::TransmitFrame>(&action)) {
    line_actions_.push(Transmit{bus, transmit->frame});
  } else if (std::holds_alternative<bus::LookAtLine>(action)) {
    line_actions_.push(Look{bus});
  } else if (std::holds_alternative<bus::OpenLine>(action)) {
    line_actions_.push(Open{bus});
  } else if (std::holds_alternative<bus::CloseLine>(action)) {
    if (!buses_[bus].link().serves()) {
      report(BusLost{bus});
    }
    line_actions_.push(Shut{bus});
  } else if (const auto* reopen = std::get_if<bus::ReopenLine>(&action)) {
    if (reopen->first) {
      report(AdapterSilent{bus, reopen->silence, reopen->requests});
    }
    line_actions_.push(Shut{bus});
    line_actions_.push(Open{bus});
  } else if (const auto* notice = std::get_if<bus::DeviceNotice>(&action)) {
    report(DeviceNews{bus, *notice});
  } else if (std::holds_alternative<bus::NeverSilent>(action)) {
    report(LineNeverSilent{bus});
  } else if (const auto* quality = std::get_if<bus::QualityNotice>(&action)) {
    report(QualityNews{bus, *quality});
  } else if (const auto* fault = std::get_if<bus::LineNotice>(&action)) {
    report(LineNews{bus, fault->fault});
  }
}

void Lines::adopt(const Settings& before, const Settings& next, Instant now) {
  for (const BusSet::GivenUp& given_up : buses_.adopt(before, next, now)) {
    // What was on the wire ends, and what waits: also on a connection that the server has closed,
    // where a refused stop may wait for its next try. Nobody needs its news any more.
    given_up.bus->handle_lost(now);
    given_up.bus->give_up(now);
    // The drives are the same ones if only the name of the bus, or the settings of its line, have
    // changed: stops go on.
    const bus::LineSettings& line = before.bus(given_up.id).line;
    const auto same = std::ranges::find_if(
        next.buses, [&](const BusSettings& it) { return !it.is_gone && line.has_end_of(it.line); });
    const bool has_drives = same != next.buses.end();
    const auto place = static_cast<std::uint32_t>(same - next.buses.begin());
    line_actions_.push(Shut{given_up.id});
    while (const auto action = given_up.bus->poll()) {
      const auto* const ended = std::get_if<bus::JobEnded>(&*action);
      if (ended != nullptr &&
          !(has_drives && exchanges_.begin_anew(*ended->job, BusId{place}, now))) {
        exchanges_.end(*ended->job, ended->ending);
      }
    }
  }
}

}  // namespace mbgate::gateway
