// SPDX-License-Identifier: Apache-2.0
// Between the wires and the gateway: what is transmitted and heard, and lines that come and go.
#include <algorithm>

#include "world/world.hpp"

namespace mbgate::world {
namespace {

constexpr Duration kRemembered = 30s;
constexpr std::uint8_t kOtherBroadcast = 129;

bool covers(const Intent& intent, const Range& read) {
  return intent.reads && intent.reads->table == read.table && intent.reads->first <= read.first &&
         intent.reads->first + intent.reads->count >= read.first + read.count;
}

// What of a value is read with it may be more than was asked for.
Range without_rest(const Asked& asked, Range read) {
  const Intent& intent = asked.intent;
  const bool may_swap = intent.swapped || asked.outdated || asked.perhaps_outdated;
  if (!may_swap || read.table != Table::holding_registers || !intent.reads) {
    return read;
  }
  const unsigned first = std::max(read.first, intent.reads->first);
  const unsigned end = std::min(read.first + read.count, intent.reads->first + intent.reads->count);
  const bool widened =
      first < end && read.first >= value_begin(intent.reads->first) &&
      read.first + read.count <= value_end(intent.reads->first + intent.reads->count - 1);
  return widened ? Range{read.table, first, end - first} : read;
}

}  // namespace

Sent World::read_frame(std::size_t bus, Bytes frame) {
  Sent sent;
  sent.bus = bus;
  sent.process = ledger_.process;
  sent.opening = ledger_.lines[bus].openings;
  sent.begin = sent.end = schedule_.now();
  const bus::Framing framing = plan_.bus(bus).line.framing;
  std::optional<Adu> adu;
  if (framing == bus::Framing::tcp) {
    constexpr std::size_t kHead = 7;
    if (frame.size() > kHead && word_at(frame, 2) == 0 && word_at(frame, 4) + 6U == frame.size()) {
      adu = Adu{frame[6], Octets(frame.begin() + kHead, frame.end())};
      sent.identifier = word_at(frame, 0);
    }
  } else {
    adu = framing == bus::Framing::ascii ? read_ascii(frame) : read_rtu(frame);
    sent.end += WireTimes(plan_.bus(bus).line).of(frame.size());
  }
  if (!adu || adu->pdu.empty()) {
    return sent;
  }
  sent.readable = true;
  sent.address = adu->address;
  sent.pdu = std::move(adu->pdu);
  sent.has_other_form = framing != bus::Framing::tcp && sent.address == kOtherBroadcast;
  sent.is_broadcast = framing != bus::Framing::tcp && (sent.address == 0 || sent.has_other_form);
  if (sent.has_other_form) {
    sent.readable = sent.pdu[0] >= 0x80;
    sent.pdu[0] &= 0x7FU;
  }
  for (std::size_t at = 0; at < plan_.stations.size(); ++at) {
    const Station& station = plan_.stations[at];
    if (station.bus == bus && !sent.is_broadcast &&
        (station.every_unit || station.address == sent.address)) {
      sent.station = at;
    }
  }
  return sent;
}

void World::transmit(std::size_t bus, Octets frame) {
  const auto id = static_cast<Id>(ledger_.sent.size());
  ledger_.sent.push_back(read_frame(bus, frame));
  ++report_.transactions;
  note_sent(id);
  if (buses_[bus].open) {
    std::visit([&](auto& wire) { wire.transmit(id, std::move(frame)); }, wires_[bus]);
  }
  ledger_.lines[bus].last = id;
}

// Whose it is follows from what it says: nobody else writes these words there.
void World::note_sent(Id id) {
  Sent& sent = ledger_.sent[id];
  if (sent.readable) {
    sent.cells = cells_of(sent.pdu);
    const auto fields = fields_of(sent.pdu);
    sent.reads = fields ? fields->reads : std::nullopt;
    sent.is_stop =
        !sent.cells.empty() && sent.pdu[0] != 0x17 && std::ranges::all_of(sent.cells, is_stopping);
    sent.is_failsafe = std::ranges::any_of(sent.cells, [](const Cell& cell) {
      return cell.table == Table::holding_registers && cell.place == kFailsafeRegister;
    });
    sent.expects_answer = !sent.is_broadcast && !is_silent_write(sent.pdu);
    std::size_t place = sent.is_broadcast ? all_of(sent.bus) : sent.station.value_or(0);
    if (sent.is_broadcast || sent.station) {
      for (const Cell& cell : sent.cells) {
        ledger_.carriers[key_of(place, cell)].push_back(id);
        const auto found = ledger_.writer.find(key_of(place, cell));
        if (found != ledger_.writer.end() && std::ranges::count(sent.asked, found->second) == 0) {
          sent.asked.push_back(found->second);
        }
      }
    }
    if (sent.station && sent.cells.empty()) {
      auto& open = ledger_.open_reads[*sent.station];
      std::erase_if(open, [&](Id asked) {
        return ledger_.asked[asked].answers > 0 || ledger_.asked[asked].dropped;
      });
      for (const Id asked : open) {
        const Intent& intent = ledger_.asked[asked].intent;
        const bool is_its = sent.reads
                                ? covers(intent, without_rest(ledger_.asked[asked], *sent.reads))
                                : intent.pdu == sent.pdu;
        if (is_its) {
          sent.asked.push_back(asked);
        }
      }
    }
    for (const Id asked : sent.asked) {
      ledger_.asked[asked].sent.push_back(id);
    }
  }
  witness_->sent(id);
  if (sent.station) {
    auto& last = ledger_.last_sent[*sent.station];
    std::erase_if(last, [&](Id old) { return ledger_.sent[old].end + kRemembered < sent.begin; });
    last.push_back(id);
  }
}

std::optional<std::size_t> World::bus_of(gateway::BusId id) const {
  for (std::size_t bus = 0; bus < buses_.size(); ++bus) {
    if (gateway::BusId{buses_[bus].id} == id) {
      return bus;
    }
  }
  return std::nullopt;
}

void World::tell_unsent(std::size_t bus) {
  if (!plan_.lines[bus].tells_unsent || !buses_[bus].open || !ledger_.lines[bus].open) {
    return;
  }
  const std::size_t bytes = std::get<Line>(wires_[bus]).unsent();
  if (bytes != std::exchange(buses_[bus].unsent, bytes)) {
    harness_->handle(gateway::LineUnsent{gateway::BusId{buses_[bus].id}, bytes}, schedule_.now());
  }
}

void World::open(std::size_t bus) {
  schedule_.after(random_.duration(10us, 5ms), [this, bus, epoch = buses_[bus].epoch] {
    BusState& state = buses_[bus];
    if (epoch != state.epoch) {
      return;  // nobody wants that line any more
    }
    const bool refused = schedule_.now() < state.away_until;
    if (!refused) {
      state.open = true;
      state.unsent = 0;
      std::visit([](auto& wire) { wire.open(); }, wires_[bus]);
    }
    driver_.post([this, bus, epoch, refused] {
      if (epoch == buses_[bus].epoch) {
        opened(bus, refused);
      }
    });
  });
}

void World::opened(std::size_t bus, bool refused) {
  const gateway::BusId id{buses_[bus].id};
  if (refused) {
    report_.fault("open_refused");
    hand_in(gateway::LineLost{id});
    return;
  }
  LineBook& line = ledger_.lines[bus];
  line.open = true;
  ++line.openings;
  line.opened = schedule_.now();
  line.last = kNone;
  hand_in(gateway::LineOpened{id, plan_.lines[bus].kind});
  driver_.watch_line(bus);
}

// The gateway wants it closed: nothing comes from it, or a reload has changed it.
void World::shut(std::uint32_t id) {
  if (const auto bus = bus_of(gateway::BusId{id})) {
    report_.fault("line_shut");
    close_line(*bus);
  }
}

void World::close_line(std::size_t bus) {
  BusState& state = buses_[bus];
  ++state.epoch;
  state.open = false;
  std::visit([](auto& wire) { wire.close(); }, wires_[bus]);
  driver_.forget_line(bus);
  ledger_.lines[bus].open = false;
  ledger_.lines[bus].closed = schedule_.now();
}

void World::deliver(std::size_t bus, const Octets& bytes, const Came& came) {
  if (!buses_[bus].open || bytes.empty()) {
    return;
  }
  LineBook& line = ledger_.lines[bus];
  line.heard = came.at;
  line.said = came.said;
  line.came.push_back(came);
  while (line.came.front().at + kRemembered < came.at) {
    line.came.pop_front();
  }
  if (came.answers != kNone && came.fits && !came.is_second) {
    Sent& sent = ledger_.sent[came.answers];
    sent.answered = std::min(sent.answered, came.at);
  }
  if (trace_ && came.answers != kNone) {
    const Sent& sent = ledger_.sent[came.answers];
    trace("  here ends " + std::string(came.is_second ? "a second answer" : "the answer") + " to " +
          hex(sent.pdu) + " of " +
          std::to_string(static_cast<double>(sent.begin.time_since_epoch().count()) / 1e9));
  }
  driver_.line_bytes(bus, bytes);
  witness_->came(bus);
}

void World::begin_losses(std::size_t bus) {
  const Duration every = plan_.lines[bus].lost_every;
  if (every > Duration{0}) {
    schedule_.after(random_.duration(every / 4, 2 * every), [this, bus] {
      if (!ledger_.calm) {
        report_.fault("line_lost");
        lose(bus, bus::Loss::failed);
        begin_losses(bus);
      }
    });
  }
}

void World::lose(std::size_t bus, bus::Loss loss) {
  BusState& state = buses_[bus];
  if (!state.open) {
    return;
  }
  state.open = false;
  if (loss == bus::Loss::failed) {
    state.away_until =
        schedule_.now() + random_.duration(0ms, random_.one_of<Duration>({1s, 1s, 15s}));
  }
  losses_[bus] = loss;
  std::visit([](auto& wire) { wire.close(); }, wires_[bus]);
  ledger_.lines[bus].open = false;
  ledger_.lines[bus].closed = schedule_.now();
  driver_.line_lost(bus);
}

}  // namespace mbgate::world
