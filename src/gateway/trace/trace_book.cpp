// SPDX-License-Identifier: Apache-2.0
#include "gateway/trace/trace_book.hpp"

#include <algorithm>
#include <chrono>
#include <utility>

namespace mbgate::gateway {
namespace {

/// Bytes that nobody asked for and that come so close behind each other are told together: longer
/// than what an adapter keeps.
constexpr Duration kPause = std::chrono::milliseconds(50);

void keep(WireTrace& wire, modbus::Bytes bytes, Instant now) {
  std::size_t kept = 0;
  for (const HeardBytes& part : wire.heard) {
    kept += part.bytes.size();
  }
  const std::size_t room = TraceBook::kMostHeard - kept;
  const modbus::Bytes taken = bytes.first(std::min(room, bytes.size()));
  wire.not_kept += bytes.size() - taken.size();
  if (!taken.empty()) {
    wire.heard.push_back({now, {taken.begin(), taken.end()}});
  }
}

WireTrace::Outcome outcome_of(bus::LineEnd::How how) {
  switch (how) {
    case bus::LineEnd::How::response: return WireTrace::Outcome::answered;
    case bus::LineEnd::How::sent: return WireTrace::Outcome::sent;
    case bus::LineEnd::How::no_response: return WireTrace::Outcome::no_response;
    case bus::LineEnd::How::damaged: return WireTrace::Outcome::damaged;
  }
  return WireTrace::Outcome::cut;
}

bool is_transaction_of(modbus::Bytes adu, const WireTrace& wire) {
  constexpr std::size_t kIdentifier = 2;
  return wire.frame.size() >= kIdentifier &&
         std::ranges::equal(adu.first(kIdentifier), modbus::Bytes(wire.frame).first(kIdentifier));
}

}  // namespace

bool TraceRecord::is_failed() const {
  if (asked && !asked->answer) {
    return true;
  }
  constexpr std::uint8_t kException = 0x80;
  if (asked && ((*asked->answer)[modbus::kMbapHeaderSize] & kException) != 0) {
    return true;
  }
  return std::ranges::any_of(wire, [](const WireTrace& it) {
    return it.outcome != WireTrace::Outcome::answered && it.outcome != WireTrace::Outcome::sent;
  });
}

void TraceBook::set_on(bool on) {
  on_ = on;
  if (!on) {
    open_.clear();
    lines_.clear();
    finished_.clear();
    lost_ = 0;
  }
}

void TraceBook::refused(AskedTrace asked) {
  asked.refused = true;
  TraceRecord record;
  record.asked = std::move(asked);
  finish(std::move(record));
}

void TraceBook::asked(std::uint32_t exchange, AskedTrace asked) {
  open_[exchange] = TraceRecord{std::move(asked), {}, 0, std::nullopt};
}

void TraceBook::job_ended(std::uint32_t exchange, bus::Ending ending) {
  if (const auto open = open_.find(exchange); open != open_.end()) {
    open->second.ended_as = ending;
  }
}

void TraceBook::answered(std::uint32_t exchange, const std::optional<modbus::MbapAdu>& answer,
                         Instant now) {
  for (auto& [bus, line] : lines_) {
    std::erase_if(line.in_flight, [&](InFlight& it) {
      const bool is_its = std::ranges::count(it.title.requests, exchange) > 0;
      if (is_its) {
        end_cut(it, now);
      }
      return is_its;
    });
  }
  const auto open = open_.find(exchange);
  if (open == open_.end()) {
    return;
  }
  TraceRecord record = std::move(open->second);
  open_.erase(open);
  record.asked->answered_at = now;
  if (answer) {
    const modbus::MbapBytes bytes = modbus::encode(*answer);
    record.asked->answer = ByteString(bytes.begin(), bytes.end());
  }
  finish(std::move(record));
}

WireTrace TraceBook::wire_of(BusId bus, std::uint8_t address) const {
  const Settings& settings = settings_.settings();
  WireTrace wire;
  wire.bus = settings.bus(bus).name;
  wire.framing = settings.bus(bus).line.framing;
  wire.address = address;
  const auto device = std::ranges::find_if(settings.devices, [&](const drive::Device& it) {
    return it.bus == bus && it.address == address;
  });
  wire.device = device == settings.devices.end() ? "" : device->name;
  return wire;
}

void TraceBook::opened(BusId bus, Instant now) {
  Line& line = lines_[bus];
  for (InFlight& cut : line.in_flight) {
    end_cut(cut, now);
  }
  line.in_flight.clear();
  line.partial.clear();
  end_unasked(line);
}

// A transmission that has no end by now was cut: a job has one at a time, and so has a serial line.
void TraceBook::began(BusId bus, const bus::TransmissionBegan& began, Instant now) {
  Line& line = lines_[bus];
  end_unasked(line);
  WireTrace wire = wire_of(bus, began.address);
  std::erase_if(line.in_flight, [&](InFlight& it) {
    const bool is_cut = it.title.job == began.title.job || wire.framing != bus::Framing::tcp;
    if (is_cut) {
      end_cut(it, now);
    }
    return is_cut;
  });
  if (began.is_broadcast) {
    wire.device.clear();
  }
  wire.tries = began.tries;
  wire.shared_by = began.title.requests.size();
  wire.sent_at = now;
  line.in_flight.push_back({began.title, std::move(wire)});
}

void TraceBook::transmitted(BusId bus, modbus::Bytes frame) {
  Line& line = lines_[bus];
  if (!line.in_flight.empty()) {
    line.in_flight.back().wire.frame.assign(frame.begin(), frame.end());
  }
}

void TraceBook::heard(BusId bus, modbus::Bytes bytes, Instant now) {
  Line& line = lines_[bus];
  if (settings_.settings().bus(bus).line.framing == bus::Framing::tcp) {
    hear_adus(bus, bytes, now);
  } else if (line.in_flight.empty()) {
    hear_unasked(bus, bytes, now);
  } else {
    keep(line.in_flight.front().wire, bytes, now);
  }
}

// A connection may carry several at a time: what belongs together is told by the identifier.
void TraceBook::hear_adus(BusId bus, modbus::Bytes bytes, Instant now) {
  Line& line = lines_[bus];
  line.partial.insert(line.partial.end(), bytes.begin(), bytes.end());
  modbus::Bytes rest = line.partial;
  while (!rest.empty()) {
    const modbus::MbapScan scan = modbus::scan_mbap(rest);
    std::size_t size = rest.size();
    if (std::holds_alternative<modbus::MbapIncomplete>(scan)) {
      break;
    }
    if (const auto* frame = std::get_if<modbus::MbapFrame>(&scan)) {
      size = frame->size;
    } else if (const auto* foreign = std::get_if<modbus::MbapForeign>(&scan)) {
      size = std::min(foreign->size, rest.size());
    }
    const modbus::Bytes adu = rest.first(size);
    const auto asked = std::ranges::find_if(
        line.in_flight, [&](const InFlight& it) { return is_transaction_of(adu, it.wire); });
    if (asked != line.in_flight.end()) {
      keep(asked->wire, adu, now);
    } else {
      end_unasked(line);
      hear_unasked(bus, adu, now);
    }
    rest = rest.subspan(size);
  }
  line.partial = ByteString(rest.begin(), rest.end());
}

void TraceBook::hear_unasked(BusId bus, modbus::Bytes bytes, Instant now) {
  Line& line = lines_[bus];
  if (line.unasked && now - line.unasked->ended_at >= kPause) {
    end_unasked(line);
  }
  if (!line.unasked) {
    line.unasked = wire_of(bus, bytes.front());
    line.unasked->device.clear();
    line.unasked->outcome = WireTrace::Outcome::unasked;
    line.unasked->sent_at = now;
  }
  keep(*line.unasked, bytes, now);
  line.unasked->ended_at = now;
}

void TraceBook::over(BusId bus, const bus::TransmissionOver& over, Instant now) {
  Line& line = lines_[bus];
  const auto it = std::ranges::find_if(
      line.in_flight, [&](const InFlight& flight) { return flight.title.job == over.title.job; });
  if (it == line.in_flight.end()) {
    line.unasked.reset();  // it began before anybody read along: what was heard is its answer
    return;
  }
  WireTrace wire = std::move(it->wire);
  line.in_flight.erase(it);
  wire.outcome = outcome_of(over.how);
  wire.ended_at = now;
  wire.shared_by = over.title.requests.size();
  if (over.response) {
    const modbus::Bytes pdu = over.response->bytes();
    wire.response = ByteString(pdu.begin(), pdu.end());
  }
  give(over.title, wire);
}

void TraceBook::give(const bus::TransmissionTitle& title, const WireTrace& wire) {
  bool is_given = false;
  for (const std::uint32_t request : title.requests) {
    const auto open = open_.find(request);
    if (open == open_.end()) {
      continue;
    }
    is_given = true;
    if (open->second.wire.size() < kMostWires) {
      open->second.wire.push_back(wire);
    } else {
      ++open->second.wire_not_kept;
    }
  }
  if (!is_given) {
    finish({std::nullopt, {wire}, 0, std::nullopt});
  }
}

void TraceBook::end_cut(InFlight& cut, Instant now) {
  cut.wire.outcome = WireTrace::Outcome::cut;
  cut.wire.ended_at = now;
  give(cut.title, cut.wire);
}

void TraceBook::end_unasked(Line& line) {
  if (line.unasked) {
    finish({std::nullopt, {*std::exchange(line.unasked, std::nullopt)}, 0, std::nullopt});
  }
}

void TraceBook::finish(TraceRecord record) {
  if (finished_.size() == kMostRecords) {
    finished_.pop_front();
    ++lost_;
  }
  finished_.push_back(std::move(record));
}

TraceBook::Taken TraceBook::take(Instant now) {
  for (auto& [bus, line] : lines_) {
    if (line.unasked && now - line.unasked->ended_at >= kPause) {
      end_unasked(line);
    }
  }
  Taken taken{
      {std::make_move_iterator(finished_.begin()), std::make_move_iterator(finished_.end())},
      std::exchange(lost_, 0)};
  finished_.clear();
  return taken;
}

}  // namespace mbgate::gateway
