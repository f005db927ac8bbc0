// SPDX-License-Identifier: Apache-2.0
// Between the wires and the gateway: what is transmitted and heard, and lines that come and go.
#include "soak/pdus.hpp"
#include "soak/world.hpp"

namespace mbgate::soak {

using namespace std::chrono_literals;

void World::transmit(std::size_t bus, Bytes frame) {
  const Flight& flight = oracle_.transmitted(bus, frame);
  object(bus, hangs_.transmitted(flight));
  if (!buses_[bus].open) {
    return;  // the process does not know it yet
  }
  if (auto* serial = std::get_if<SerialWire>(&wires_[bus])) {
    serial->transmit(flight, frame);
  } else {
    std::get<FarServer>(wires_[bus]).transmit(flight);
  }
}

void World::deliver(std::size_t bus, const std::vector<std::uint8_t>& bytes) {
  if (buses_[bus].open) {
    driver_.line_bytes(bus, bytes);
  }
}

void World::hand_in(std::size_t bus, Bytes bytes) {
  if (trace_) {
    trace(plan_.settings.buses[bus].name + " < " + hex(bytes));
  }
  oracle_.bytes_handed_in(bus);
  hangs_.read(bus, schedule_.now());
  harness_.handle(gateway::LineBytes{id_of(bus), bytes}, schedule_.now());
  drain();
}

void World::open(std::size_t bus) {
  oracle_.bus_opening(bus);
  schedule_.after(random_.duration(10us, 5ms), [this, bus, epoch = buses_[bus].epoch] {
    BusState& state = buses_[bus];
    if (epoch != state.epoch) {
      return;  // nobody wants that line any more
    }
    const bool refused = schedule_.now() < state.away_until;
    if (refused) {
      report_.fault("open_refused");
    } else {
      swap_adapter(bus);
      state.open = true;
      state.framing_lost = false;
      state.end = End::lost;
      std::visit([](auto& wire) { wire.reset(true); }, wires_[bus]);
      if (auto* server = std::get_if<FarServer>(&wires_[bus])) {
        server->begin_connection();
      }
    }
    driver_.post([this, bus, epoch, refused] {
      if (epoch == buses_[bus].epoch) {
        opened(bus, refused);
      }
    });
  });
}

// Nobody has said whether it hears itself: that must be found out anew.
void World::swap_adapter(std::size_t bus) {
  const bus::LineSettings& line = plan_.settings.buses[bus].line;
  const bool may_differ = line.framing != bus::Framing::tcp && !line.remote && !line.echo;
  if (may_differ && plan_.theme == Theme::none && swaps_.chance(plan_.rates[bus].swapped)) {
    report_.fault("adapter_swapped");
    plan_.echoes[bus] = !plan_.echoes[bus];
  }
}

void World::opened(std::size_t bus, bool refused) {
  if (refused) {
    oracle_.bus_lost(bus);
    harness_.handle(gateway::LineLost{id_of(bus)}, schedule_.now());
  } else {
    const auto& line = plan_.settings.buses[bus].line;
    trace(plan_.settings.buses[bus].name + ": echo = " +
          (!line.echo   ? "auto"
           : *line.echo ? "true"
                        : "false") +
          (plan_.echoes[bus] ? ", it is there" : ", there is none") +
          (is_paced(plan_, bus) ? ", paced" : ", not paced"));
    oracle_.bus_opened(bus);
    hangs_.opened(bus, schedule_.now());
    harness_.handle(gateway::LineOpened{id_of(bus), plan_.kinds[bus]}, schedule_.now());
    driver_.watch_line(bus);
  }
  drain();
}

// Because of a reload, or because nothing comes from a connection or an adapter.
void World::shut(std::size_t bus) {
  if (shut_due_.erase(bus) > 0) {
    return;
  }
  BusState& state = buses_[bus];
  state.open = false;
  std::visit([](auto& wire) { wire.reset(false); }, wires_[bus]);
  driver_.forget_line(bus);
  if (state.framing_lost) {
    oracle_.bus_lost(bus);
    return;
  }
  const bool is_serial = std::holds_alternative<SerialWire>(wires_[bus]);
  report_.fault(is_serial ? "restarted" : "replaced");
  oracle_.line_replaced(bus);
  object(bus, is_serial ? hangs_.restarted(bus, schedule_.now()) : "");
}

// To what the gateway makes of a line from which nothing comes.
void World::object(std::size_t bus, const std::string& objection) const {
  if (!objection.empty()) {
    oracle_.violation("hung_line", plan_.settings.buses[bus].name + ": " + objection);
  }
}

void World::hang_up(std::size_t bus, bool answered) {
  BusState& state = buses_[bus];
  if (state.open) {
    state.open = false;
    state.end = answered ? End::closed_after_answers : End::closed;
    std::visit([](auto& wire) { wire.reset(false); }, wires_[bus]);
    driver_.line_lost(bus);
  }
}

// The process has noticed it.
void World::lost(std::size_t bus) {
  const End end = std::exchange(buses_[bus].end, End::lost);
  order_only_ = false;  // what this leads to is not the other order's doing
  const bool in_order =
      end == End::closed_after_answers || (end == End::closed && oracle_.was_idle(bus));
  in_order ? oracle_.tcp_closed(bus) : oracle_.bus_lost(bus);
  harness_.handle(
      gateway::LineLost{id_of(bus), end == End::lost ? bus::Loss::failed : bus::Loss::closed},
      schedule_.now());
  drain();
}

void World::begin_losses(std::size_t bus) {
  const Duration every = plan_.rates[bus].lost_every;
  if (every == Duration{0}) {
    return;
  }
  schedule_.after(random_.duration(every / 4, 2 * every), [this, bus] {
    if (trouble_) {
      lose(bus);
      begin_losses(bus);
    }
  });
}

void World::lose(std::size_t bus) {
  BusState& state = buses_[bus];
  if (!state.open) {
    return;
  }
  report_.fault("line_lost");
  state.open = false;
  state.away_until = schedule_.now() + random_.duration(0ms, 1s);
  std::visit([](auto& wire) { wire.reset(false); }, wires_[bus]);
  driver_.line_lost(bus);
}

}  // namespace mbgate::soak
