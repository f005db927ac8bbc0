// SPDX-License-Identifier: Apache-2.0
#include "gateway/trace/trace_book.hpp"

#include <algorithm>

namespace mbgate::gateway {

bool TraceRecord::is_failed() const {
  if (asked && !asked->answer && ended_as != bus::Ending::transmitted) {
    return true;
  }
  constexpr std::uint8_t kException = 0x80;
  if (asked && asked->answer && ((*asked->answer)[modbus::kMbapHeaderSize] & kException) != 0) {
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

void TraceBook::asked(std::uint32_t exchange, AskedTrace asked, const routing::Plan& plan) {
  for (const drive::Transaction& planned : plan.transactions()) {
    const WireTrace wire = blank(planned.bus, planned.address);
    const bool is_broadcast = planned.broadcast.has_value();
    const AskedTrace::Target target{wire.bus, is_broadcast ? "" : wire.device};
    if (std::ranges::find(asked.targets, target) == asked.targets.end()) {
      asked.targets.push_back(target);
    }
  }
  open_[exchange] = TraceRecord{std::move(asked), {}, 0, std::nullopt};
}

void TraceBook::answered(std::uint32_t exchange, const Answer& answer) {
  for (auto& [bus, line] : lines_) {
    line.answered(exchange, answer.at);
    collect(line);
  }
  const auto open = open_.find(exchange);
  if (open == open_.end()) {
    return;
  }
  TraceRecord record = std::move(open->second);
  open_.erase(open);
  record.ended_as = answer.ended_as;
  record.asked->answered_at = answer.at;
  if (answer.adu) {
    const modbus::MbapBytes bytes = modbus::encode(*answer.adu);
    record.asked->answer = ByteString(bytes.begin(), bytes.end());
  }
  finish(std::move(record));
}

WireTrace TraceBook::blank(BusId bus, std::uint8_t address) const {
  const Settings& settings = settings_.settings();
  WireTrace wire;
  wire.bus = settings.bus(bus).name;
  wire.framing = settings.bus(bus).line.framing;
  wire.address = address;
  wire.device = settings.device_name(bus, address);
  return wire;
}

void TraceBook::opened(BusId bus, Instant now) {
  lines_[bus].opened(blank(bus), now);
  collect(lines_[bus]);
}

void TraceBook::acted(BusId bus, const bus::BusAction& action, Instant now) {
  LineTrace& line = lines_[bus];
  if (const auto* began = std::get_if<bus::TransmissionBegan>(&action)) {
    WireTrace wire = blank(bus, began->address);
    wire.device = began->is_broadcast ? "" : wire.device;
    wire.sent_at = now;
    line.began(*began, std::move(wire));
  } else if (const auto* transmit = std::get_if<bus::TransmitFrame>(&action)) {
    line.transmitted(transmit->frame);
  } else if (const auto* over = std::get_if<bus::TransmissionOver>(&action)) {
    line.over(*over, now);
  }
  collect(line);
}

void TraceBook::heard(BusId bus, modbus::Bytes bytes, Instant now) {
  lines_[bus].heard(bytes, blank(bus), now);
  collect(lines_[bus]);
}

void TraceBook::collect(LineTrace& line) {
  for (const LineTrace::Told& told : line.take()) {
    bool is_given = false;
    for (const std::uint32_t request : told.title.requests) {
      if (const auto open = open_.find(request); open != open_.end()) {
        is_given = true;
        if (open->second.wire.size() < kMostWires) {
          open->second.wire.push_back(told.wire);
        } else {
          ++open->second.wire_not_kept;
        }
      }
    }
    if (!is_given) {
      finish({std::nullopt, {told.wire}, 0, std::nullopt});
    }
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
    line.rest(now);
    collect(line);
  }
  Taken taken{
      {std::make_move_iterator(finished_.begin()), std::make_move_iterator(finished_.end())},
      std::exchange(lost_, 0)};
  finished_.clear();
  return taken;
}

}  // namespace mbgate::gateway
