// SPDX-License-Identifier: Apache-2.0
#include "bus/serial_line.hpp"

#include <algorithm>
#include <utility>
#include <vector>

namespace mbgate::bus {
namespace {

// Autonics' form of a broadcast has a function of its own (AiC manual, section 2.13).
modbus::Pdu pdu_on_wire(const Transaction& transaction) {
  const modbus::Pdu& pdu = transaction.request.pdu();
  if (transaction.broadcast != drive::BroadcastForm::autonics) {
    return pdu;
  }
  std::vector<std::uint8_t> bytes(pdu.bytes().begin(), pdu.bytes().end());
  bytes.front() = static_cast<std::uint8_t>(pdu.function() | modbus::kExceptionBit);
  return *modbus::Pdu::from(bytes);
}

// Less than this is no proof: clocks differ, and so does what a drive counts its wait from.
constexpr int kEarlyPart = 8;  // of the response wait

}  // namespace

SerialLine::SerialLine(const BusSettings& settings, Duration listen_first, BusCounters& counters)
    : timing_(settings.line.baud, settings.line.format),
      frame_gap_(settings.frame_gap.value_or(timing_.t3_5())),
      turnaround_(settings.turnaround),
      settle_(settings.settle),
      listen_first_(listen_first),
      echo_(settings.line.echo),
      counters_(counters),
      framer_(settings.line.framing, timing_, counters) {}

void SerialLine::open(Instant now) {
  abort();
  quiet_since_ = now;
  listening_until_ = now + listen_first_;
  settling_until_ = now;
  turnaround_until_ = std::max(turnaround_until_, now);  // the drives know nothing of the adapter
}

void SerialLine::update(const BusSettings& settings, Duration listen_first) {
  listen_first_ = listen_first;
  frame_gap_ = settings.frame_gap.value_or(timing_.t3_5());
  turnaround_ = settings.turnaround;
  settle_ = settings.settle;
}

Instant SerialLine::ready_at(Duration gap) const {
  return std::max(
      {quiet_since_ + frame_gap_ + gap, settling_until_, listening_until_, turnaround_until_});
}

Instant SerialLine::ready_for_stop_at() const {
  return std::max(quiet_since_ + frame_gap_, turnaround_until_);
}

FrameBytes SerialLine::begin(Transaction& transaction, const drive::DeviceTiming& timing,
                             unsigned owed, Instant now) {
  const FrameBytes frame = framer_.encode(transaction.address, pdu_on_wire(transaction));
  transaction_ = &transaction;
  end_.reset();
  emission_ends_ = now + timing_.duration_of(frame.size());
  quiet_since_ = emission_ends_;
  response_wait_ = timing.response_wait;
  owed_ = owed;
  asked_ = transaction.address;
  draining_ = false;
  response_due_ =
      emission_ends_ +
      (transaction.boot_time ? turnaround_ : timing.response_timeout + timing.response_wait);
  response_deadline_ = response_due_;
  echo_seen_ = 0;
  echo_spoilt_ = false;
  if (echo_) {
    echo_expected_ = frame;
  }
  if (transaction.is_broadcast()) {
    turnaround_until_ = emission_ends_ + turnaround_;
    framer_.listen();
  } else {
    framer_.expect(transaction);
  }
  return frame;
}

void SerialLine::limit_wait(const Transaction& /*transaction*/, Instant instant, Duration least) {
  response_deadline_ = std::min(response_deadline_, std::max(instant, emission_ends_ + least));
}

void SerialLine::abort() {
  framer_.listen();
  transaction_ = nullptr;
  echo_expected_.clear();
  end_.reset();
}

void SerialLine::end(LineEnd::How how) {
  const bool early = how == LineEnd::How::response && response_wait_ > Duration{0} && is_early();
  end_ = LineEnd{how, std::exchange(transaction_, nullptr), response_due_, early};
  framer_.listen();
}

bool SerialLine::is_early() const {
  return framer_.response_began() < emission_ends_ + response_wait_ - response_wait_ / kEarlyPart;
}

// While an answer is owed, of all writes only stops are sent. An exception names no address: it may
// be the answer to the write that was stopped.
bool SerialLine::may_refuse_another() const {
  return transaction_->request.writes() && framer_.response().is_exception();
}

modbus::Bytes SerialLine::compare_echo(modbus::Bytes bytes) {
  const std::size_t count = std::min(bytes.size(), echo_expected_.size() - echo_seen_);
  const auto expected = echo_expected_.begin() + static_cast<std::ptrdiff_t>(echo_seen_);
  if (std::equal(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(count), expected)) {
    echo_seen_ += count;
    return bytes.subspan(count);
  }
  echo_seen_ = echo_expected_.size();
  echo_spoilt_ = true;
  fault_ = LineFault::echo_differed;
  ++counters_.echo_mismatches;
  counters_.stray_bytes += bytes.size();
  return {};
}

void SerialLine::handle_bytes(modbus::Bytes bytes, Instant now) {
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
  draining_ = draining_ || transaction_ == nullptr;
  if (echo_spoilt_) {
    counters_.stray_bytes += bytes.size();
    return;
  }
  judge(framer_.add(bytes, now), now);
}

void SerialLine::judge(Verdict verdict, Instant now) {
  while (verdict == Verdict::response && owed_ > 0 && (is_early() || may_refuse_another())) {
    // It began before the device can have answered this request, or says no to any request: it is
    // one of those that it owes.
    --owed_;
    ++refused_;
    verdict = framer_.again(now);
  }
  switch (verdict) {
    case Verdict::none: return;
    case Verdict::response:
      transaction_->response = framer_.response();
      end(LineEnd::How::response);
      return;
    case Verdict::damaged:
      draining_ = true;
      end(LineEnd::How::damaged);
      return;
  }
}

void SerialLine::handle_deadline(Instant now) {
  if (transaction_ == nullptr) {
    return;
  }
  if (transaction_->is_broadcast()) {
    if (now >= emission_ends_) {
      end(LineEnd::How::sent);
    }
    return;
  }
  judge(framer_.handle_deadline(now), now);
  if (transaction_ != nullptr && now >= response_deadline_ && !framer_.in_progress()) {
    if (!transaction_->may_stay_silent()) {
      settling_until_ = std::max(settling_until_, now + settle_);
    }
    end(LineEnd::How::no_response);
  }
}

std::optional<Instant> SerialLine::next_deadline() const {
  if (transaction_ == nullptr) {
    return std::nullopt;
  }
  if (transaction_->is_broadcast()) {
    return emission_ends_;
  }
  return framer_.in_progress() ? framer_.next_deadline() : response_deadline_;
}

std::optional<LineEnd> SerialLine::take_end() { return std::exchange(end_, std::nullopt); }

std::optional<LineFault> SerialLine::take_fault() { return std::exchange(fault_, std::nullopt); }

std::optional<Stray> SerialLine::take_stray() {
  if (refused_ > 0) {
    --refused_;
    return Stray{asked_, true};
  }
  return framer_.take_stray();
}

LineState SerialLine::state(Instant now) const {
  if (transaction_ != nullptr) {
    return now < emission_ends_ ? LineState::emission : LineState::waiting_for_reply;
  }
  if (now < listening_until_) {
    return LineState::initial;
  }
  if (now < turnaround_until_) {
    return LineState::waiting_turnaround_delay;
  }
  return draining_ && now < quiet_since_ + frame_gap_ ? LineState::draining : LineState::idle;
}

}  // namespace mbgate::bus
