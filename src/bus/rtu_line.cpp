// SPDX-License-Identifier: Apache-2.0
#include "bus/rtu_line.hpp"

#include <algorithm>
#include <utility>

namespace mbgate::bus {

RtuLine::RtuLine(const BusSettings& settings, Duration listen_first, BusCounters& counters)
    : timing_(settings.line.baud, settings.line.format),
      frame_gap_(settings.frame_gap.value_or(timing_.t3_5())),
      turnaround_(settings.turnaround),
      settle_(settings.settle),
      listen_first_(listen_first),
      echo_(settings.line.echo),
      counters_(counters),
      framer_(timing_, counters) {}

void RtuLine::open(Instant now) {
  abort();
  quiet_since_ = now;
  listening_until_ = not_before_ = now + listen_first_;
  turnaround_until_ = now;
}

Instant RtuLine::ready_at(Duration gap) const {
  return std::max(quiet_since_ + frame_gap_ + gap, not_before_);
}

FrameBytes RtuLine::begin(const Transaction& transaction, const drive::DeviceTiming& timing,
                          Instant now) {
  const modbus::RtuBytes frame = modbus::encode_rtu(transaction.address, transaction.request.pdu());
  transaction_ = &transaction;
  end_.reset();
  emission_ends_ = now + timing_.duration_of(frame.size());
  quiet_since_ = emission_ends_;
  response_deadline_ = emission_ends_ + timing.response_timeout + timing.response_wait;
  echo_seen_ = 0;
  echo_spoilt_ = false;
  if (echo_) {
    echo_expected_ = frame;
  }
  if (transaction.is_broadcast()) {
    framer_.reset();
  } else {
    framer_.expect(transaction);
  }
  ++counters_.transmissions;
  return {frame.begin(), frame.end()};
}

void RtuLine::abort() {
  framer_.reset();
  transaction_ = nullptr;
  echo_expected_.clear();
  end_.reset();
}

void RtuLine::hold_until(Instant instant) { not_before_ = std::max(not_before_, instant); }

void RtuLine::end(End how) {
  end_ = how;
  transaction_ = nullptr;
  framer_.reset();
}

modbus::Bytes RtuLine::compare_echo(modbus::Bytes bytes) {
  const std::size_t count = std::min(bytes.size(), echo_expected_.size() - echo_seen_);
  const auto expected = echo_expected_.begin() + static_cast<std::ptrdiff_t>(echo_seen_);
  if (std::equal(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(count), expected)) {
    echo_seen_ += count;
    return bytes.subspan(count);
  }
  echo_seen_ = echo_expected_.size();
  echo_spoilt_ = true;
  echo_mismatch_ = true;
  ++counters_.echo_mismatches;
  counters_.stray_bytes += bytes.size();
  return {};
}

void RtuLine::handle_bytes(modbus::Bytes bytes, Instant now) {
  if (framer_.awaits_silence()) {
    handle_deadline(now);  // if silence has ended a frame already, these bytes are no part of it
  }
  quiet_since_ = std::max(quiet_since_, now);
  if (echo_seen_ < echo_expected_.size()) {
    bytes = compare_echo(bytes);
  }
  if (bytes.empty()) {
    return;
  }
  if (transaction_ == nullptr || transaction_->is_broadcast() || echo_spoilt_) {
    counters_.stray_bytes += bytes.size();
    return;
  }
  if (framer_.add(bytes, now) == ResponseFramer::Verdict::response) {
    end(End::response);
  }
}

void RtuLine::handle_deadline(Instant now) {
  if (transaction_ == nullptr) {
    return;
  }
  if (transaction_->is_broadcast()) {
    if (now >= emission_ends_) {
      turnaround_until_ = emission_ends_ + turnaround_;
      hold_until(turnaround_until_);
      end(End::sent);
    }
    return;
  }
  switch (framer_.handle_deadline(now)) {
    case ResponseFramer::Verdict::response: end(End::response); return;
    case ResponseFramer::Verdict::bad_crc:
      ++counters_.bad_crcs;
      end(End::bad_crc);
      return;
    case ResponseFramer::Verdict::none: break;
  }
  if (now >= response_deadline_ && !framer_.in_progress()) {
    if (!transaction_->silence_is_success) {
      ++counters_.timeouts;
      hold_until(now + settle_);
    }
    end(End::no_response);
  }
}

std::optional<Instant> RtuLine::next_deadline() const {
  if (transaction_ == nullptr) {
    return std::nullopt;
  }
  if (transaction_->is_broadcast()) {
    return emission_ends_;
  }
  return framer_.in_progress() ? framer_.next_deadline() : response_deadline_;
}

std::optional<RtuLine::End> RtuLine::take_end() { return std::exchange(end_, std::nullopt); }

bool RtuLine::take_echo_mismatch() { return std::exchange(echo_mismatch_, false); }

RtuLine::State RtuLine::state(Instant now) const {
  if (transaction_ != nullptr) {
    return now < emission_ends_ ? State::emission : State::waiting_for_reply;
  }
  if (now < listening_until_) {
    return State::initial;
  }
  return now < turnaround_until_ ? State::waiting_turnaround_delay : State::idle;
}

std::string_view to_text(RtuLine::State state) {
  switch (state) {
    case RtuLine::State::initial: return "initial";
    case RtuLine::State::idle: return "idle";
    case RtuLine::State::emission: return "emission";
    case RtuLine::State::waiting_for_reply: return "waiting for reply";
    case RtuLine::State::waiting_turnaround_delay: return "waiting turnaround delay";
  }
  return "";
}

}  // namespace mbgate::bus
