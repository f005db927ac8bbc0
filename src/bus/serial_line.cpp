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

// A USB adapter may keep an echo for so long (its latency timer, and a busy host).
constexpr Duration kEchoKept = std::chrono::milliseconds(20);

// Can the echo of this be mistaken for the answer to it? Of 05, 06, 22 and 08/00 it always is one.
bool looks_like_answer(const Transaction& transaction) {
  const auto fit = modbus::check_response(transaction.request, transaction.request.pdu().bytes());
  return !transaction.is_broadcast() && fit == modbus::ResponseFit::normal;
}

}  // namespace

SerialLine::SerialLine(const BusSettings& settings, Duration listen_first, BusCounters& counters)
    : timing_(settings.line.baud, settings.line.format),
      frame_gap_(settings.frame_gap.value_or(timing_.t3_5())),
      turnaround_(settings.turnaround),
      settle_(settings.settle),
      listen_first_(listen_first),
      echo_(!settings.line.echo   ? Echo::unknown
            : *settings.line.echo ? Echo::present
                                  : Echo::absent),
      learns_echo_(!settings.line.echo),
      paced_setting_(settings.line.paced),
      counters_(counters),
      framer_(settings, timing_, counters) {}

void SerialLine::open(Instant now, LineKind kind) {
  abort();
  paced_ = paced_setting_.value_or(kind == LineKind::uart);
  if (learns_echo_) {
    echo_ = Echo::unknown;  // it may be another adapter
  }
  unproven_told_ = unpaced_told_ = echo_shown_ = false;
  quiet_since_ = now;
  busy_since_ = now;
  emission_ends_ = now;
  listening_until_ = now + listen_first_;
  settling_until_ = now;
  turnaround_until_ = std::max(turnaround_until_, now);  // the drives know nothing of the adapter
}

void SerialLine::update(const BusSettings& settings, Duration listen_first) {
  listen_first_ = listen_first;
  frame_gap_ = settings.frame_gap.value_or(timing_.t3_5());
  turnaround_ = settings.turnaround;
  settle_ = settings.settle;
  framer_.update(settings);
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
  busy_since_ = emission_ends_;
  response_wait_ = timing.response_wait;
  owed_ = owed;
  draining_ = false;
  response_due_ =
      emission_ends_ +
      (transaction.boot_time ? turnaround_ : timing.response_timeout + timing.response_wait);
  response_deadline_ = response_due_;
  heard_ = came_ = 0;
  echo_may_answer_ = looks_like_answer(transaction);
  expect_echo(frame);
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
  echo_seen_ = 0;
  end_.reset();
}

void SerialLine::end(LineEnd::How how) {
  const bool early = how == LineEnd::How::response && response_wait_ > Duration{0} && is_early();
  end_ = LineEnd{how, std::exchange(transaction_, nullptr), response_due_,
                 std::max(quiet_since_ - emission_ends_, Duration{0}), early};
  const bool framed = how == LineEnd::How::response || how == LineEnd::How::damaged;
  end_->heard = heard_;
  end_->heard_after = heard_ > 0 ? heard_at_ - emission_ends_ : Duration{0};
  end_->noise = framed ? framer_.noise() : 0;
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

void SerialLine::expect_echo(const FrameBytes& frame) {
  if (echo_ != Echo::present && echo_seen_ < echo_expected_.size()) {
    counters_.stray_bytes += echo_seen_;  // it was held back for an echo that it was not
  }
  echo_seen_ = 0;
  echo_spoilt_ = echo_passed_ = false;
  echo_expected_.clear();
  if (echo_ == Echo::present || (learns_echo_ && !echo_may_answer_)) {
    echo_expected_ = frame;
  }
}

void SerialLine::note(LineFault fault) {
  if (faults_.size() < faults_.capacity()) {
    faults_.push_back(fault);
  }
}

void SerialLine::find_echo() {
  echo_ = Echo::present;
  echo_shown_ = true;
  note(LineFault::echo_found);
}

// As long as what comes may be the echo of what was sent, it is held back: if it is, no answer to
// that can look so, and the line hears itself.
modbus::Bytes SerialLine::look_for_echo(modbus::Bytes bytes, Instant now) {
  const std::size_t count = std::min(bytes.size(), echo_expected_.size() - echo_seen_);
  const auto expected = echo_expected_.begin() + static_cast<std::ptrdiff_t>(echo_seen_);
  if (!std::equal(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(count), expected)) {
    release_held(now);
    return bytes;
  }
  held_since_ = echo_seen_ == 0 ? now : held_since_;
  echo_seen_ += count;
  if (echo_seen_ == echo_expected_.size()) {
    find_echo();
  }
  return bytes.subspan(count);
}

void SerialLine::release_held(Instant now) {
  const FrameBytes held(echo_expected_.begin(),
                        echo_expected_.begin() + static_cast<std::ptrdiff_t>(echo_seen_));
  echo_expected_.clear();
  echo_seen_ = 0;
  if (!held.empty()) {
    judge(framer_.add({held.data(), held.size()}, held_since_), now);
  }
}

modbus::Bytes SerialLine::compare_echo(modbus::Bytes bytes) {
  const std::size_t count = std::min(bytes.size(), echo_expected_.size() - echo_seen_);
  const auto expected = echo_expected_.begin() + static_cast<std::ptrdiff_t>(echo_seen_);
  if (std::equal(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(count), expected)) {
    echo_seen_ += count;
    return bytes.subspan(count);
  }
  echo_expected_.clear();  // it never came, and is not to be held for it
  echo_seen_ = 0;
  echo_spoilt_ = true;
  note(LineFault::echo_differed);
  if (learns_echo_) {
    echo_ = Echo::unknown;  // the next read shows again what it is
  }
  ++counters_.echo_mismatches;
  counters_.stray_bytes += bytes.size();
  return {};
}

void SerialLine::handle_bytes(modbus::Bytes bytes, Instant now) {
  if (framer_.awaits_silence()) {
    handle_deadline(now);  // if silence has ended a frame already, these bytes are no part of it
  }
  if (now > quiet_since_ + frame_gap_) {
    busy_since_ = now;
  }
  quiet_since_ = std::max(quiet_since_, now);
  came_ += bytes.size();
  if (echo_seen_ < echo_expected_.size()) {
    bytes = echo_ == Echo::present ? compare_echo(bytes) : look_for_echo(bytes, now);
  }
  if (bytes.empty()) {
    return;
  }
  draining_ = draining_ || transaction_ == nullptr;
  if (echo_spoilt_) {
    counters_.stray_bytes += bytes.size();
    return;
  }
  if (now >= emission_ends_) {
    heard_at_ = heard_ == 0 ? now : heard_at_;
    heard_ += bytes.size();
  }
  judge(framer_.add(bytes, now), now);
}

// What begins before the request has left a paced line answers nothing.
Verdict SerialLine::refuse(Instant now) {
  if (learns_echo_ && repeats_request() && (owed_ == 0 || echo_ == Echo::unknown)) {
    if (owed_ == 0) {
      find_echo();
    } else {
      ++counters_.stray_frames;  // an echo, or what is owed: that stays owed
    }
    echo_passed_ = true;
  } else if (owed_ > 0) {
    // It is one of those that the device owes.
    --owed_;
    refused_.add({transaction_->address, framer_.response()});
  } else {
    ++counters_.stray_frames;
    if (transaction_->request.is_read() && !std::exchange(unpaced_told_, true)) {
      note(LineFault::answered_while_sending);
    }
  }
  return framer_.again(now);
}

bool SerialLine::repeats_request() const {
  return echo_may_answer_ && framer_.response() == transaction_->request.pdu();
}

// Until a read has shown whether the line hears itself, a repetition that comes at once may be an
// echo. If something else that fits stands behind it, it was; alone it is taken.
Verdict SerialLine::settle_echo(Verdict verdict, Instant now) {
  // It was shown that this line hears itself; or it is a read, whose answer hardly looks so.
  const bool is_echo = echo_shown_ || transaction_->request.is_read();
  const bool is_late = framer_.response_began() > emission_ends_ + kEchoKept;
  if (echo_ != Echo::unknown || !repeats_request() || (is_late && !is_echo)) {
    return verdict;
  }
  if (is_echo && std::exchange(echo_passed_, true)) {
    if (owed_ == 0) {
      find_echo();  // two came, and only one of them can be the echo
    }
    return verdict;
  }
  if (is_echo) {
    const Verdict behind = framer_.again(now);
    if (behind == Verdict::response && owed_ == 0) {
      find_echo();
    }
    return behind;
  }
  const modbus::Pdu repetition = framer_.response();
  if (owed_ == 0 && framer_.again(now) == Verdict::response) {
    find_echo();
    return Verdict::response;
  }
  if (!std::exchange(unproven_told_, true)) {
    note(LineFault::echo_unproven);
  }
  transaction_->response = repetition;
  end(LineEnd::How::response);
  return Verdict::none;
}

// An echo would have come before the answer. What came beside it may be the rest of one; and where
// one was heard, it was lost this time.
bool SerialLine::shows_no_echo() const {
  return echo_ == Echo::unknown && !echo_shown_ &&
         came_ == framer_.encode(transaction_->address, framer_.response()).size();
}

void SerialLine::judge(Verdict verdict, Instant now) {
  while (verdict == Verdict::response && paced_ && framer_.response_began() < emission_ends_) {
    verdict = refuse(now);
  }
  while (verdict == Verdict::response && owed_ > 0 && (is_early() || may_refuse_another())) {
    // It began before the device can have answered this request, or says no to any request.
    verdict = refuse(now);
  }
  if (verdict == Verdict::response) {
    verdict = settle_echo(verdict, now);
  }
  switch (verdict) {
    case Verdict::none: return;
    case Verdict::response:
      if (learns_echo_ && !echo_may_answer_ && shows_no_echo()) {
        echo_ = Echo::absent;
      }
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
  if (now >= response_deadline_ && echo_ != Echo::present && echo_seen_ > 0) {
    release_held(now);  // it has begun to answer, or it was nothing
    if (transaction_ == nullptr) {
      return;
    }
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

std::optional<LineFault> SerialLine::take_fault() {
  if (faults_.empty()) {
    return std::nullopt;
  }
  const LineFault fault = faults_.front();
  faults_.erase(faults_.begin());
  return fault;
}

std::optional<Stray> SerialLine::take_stray() {
  const auto refused = refused_.take();
  return refused ? refused : framer_.take_stray();
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
