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

}  // namespace

SerialLine::SerialLine(const BusSettings& settings, Duration listen_first, BusCounters& counters)
    : timing_(settings.line.baud, settings.line.format),
      frame_gap_(settings.frame_gap.value_or(timing_.t3_5())),
      turnaround_(settings.turnaround),
      settle_(settings.settle),
      listen_first_(listen_first),
      paced_setting_(settings.line.paced),
      counters_(counters),
      echo_(settings.line.echo, counters, faults_),
      framer_(settings, timing_, counters) {}

void SerialLine::open(Instant now, LineKind kind) {
  abort();
  paced_ = paced_setting_.value_or(kind == LineKind::uart);
  echo_.open();
  unpaced_told_ = false;
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
                             OwedAnswers owed, Instant now) {
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
  heard_ = 0;
  echo_.expect(transaction, frame, now, response_due_);
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
  echo_.forget();
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

// While an answer is owed, of all writes only stops are sent. An exception names no address, and
// the answer to 15 or 16 no value: it may be the answer to the write that was stopped.
bool SerialLine::may_answer_another() const {
  return transaction_->request.writes() && (framer_.response().is_exception() || owed_.alike > 0);
}

void SerialLine::judge_held(const Echo::Held& held, Instant now) {
  if (!held.bytes.empty()) {
    judge(framer_.add({held.bytes.data(), held.bytes.size()}, held.since), now);
  }
}

void SerialLine::handle_bytes(modbus::Bytes bytes, Instant now) {
  if (framer_.awaits_silence()) {
    handle_deadline(now);  // if silence has ended a frame already, these bytes are no part of it
  }
  if (now > quiet_since_ + frame_gap_) {
    busy_since_ = now;
  }
  quiet_since_ = std::max(quiet_since_, now);
  const Echo::Heard heard = echo_.take(bytes, now);
  judge_held(heard.held, now);
  bytes = heard.bytes;
  if (bytes.empty()) {
    return;
  }
  draining_ = draining_ || transaction_ == nullptr;
  if (echo_.is_spoilt()) {
    counters_.stray_bytes += bytes.size();
    return;
  }
  if (now >= emission_ends_) {
    heard_at_ = heard_ == 0 ? now : heard_at_;
    heard_ += bytes.size();
  }
  judge(framer_.add(bytes, now), now);
}

// It may be a late echo; what begins before the request has left a paced line answers nothing; and
// an owed answer begins before the device can have answered this request, or fits another one too.
bool SerialLine::is_no_answer() const {
  return echo_.is_owed(framer_.response()) ||
         (paced_ && framer_.response_began() < emission_ends_) ||
         (owed_.count > 0 && (is_early() || may_answer_another()));
}

Verdict SerialLine::refuse(Instant now) {
  if (echo_.take_owed(framer_.response())) {
    ++counters_.stray_frames;
  } else if (owed_.count > 0) {
    --owed_.count;
    owed_.alike -= owed_.alike > 0 && !framer_.response().is_exception() ? 1U : 0U;
    refused_.add({transaction_->address, framer_.response()});
  } else if (echo_.is_learned() && echo_.is_repetition(framer_.response())) {
    echo_.find();
  } else {
    ++counters_.stray_frames;
    if (transaction_->request.is_read() && !std::exchange(unpaced_told_, true)) {
      note_fault(faults_, LineFault::answered_while_sending);
    }
  }
  return framer_.again(now);
}

// Until a read has shown whether the line hears itself, a repetition that comes at once may be an
// echo. If something else that fits stands behind it, it was; alone it is taken.
Verdict SerialLine::settle_echo(Verdict verdict, Instant now) {
  if (!echo_.is_unknown() || !echo_.is_repetition(framer_.response()) ||
      framer_.response_began() > emission_ends_ + kEchoKept) {
    return verdict;
  }
  if (echo_.was_shown() || transaction_->request.is_read()) {
    // It was shown that this line hears itself; or it is a read, whose answer hardly looks so.
    const Verdict behind = framer_.again(now);
    if (behind == Verdict::response && owed_.count == 0) {
      echo_.find();
    }
    return behind;
  }
  const modbus::Pdu repetition = framer_.response();
  if (owed_.count == 0 && framer_.again(now) == Verdict::response) {
    echo_.find();
    return Verdict::response;
  }
  echo_.note_unproven();
  transaction_->response = repetition;
  end(LineEnd::How::response);
  return Verdict::none;
}

void SerialLine::judge(Verdict verdict, Instant now) {
  while (verdict == Verdict::response && is_no_answer()) {
    verdict = refuse(now);
  }
  if (verdict == Verdict::response) {
    verdict = settle_echo(verdict, now);
  }
  switch (verdict) {
    case Verdict::none: return;
    case Verdict::response:
      if (framer_.came_first()) {
        echo_.note_answered();
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
  if (now >= response_deadline_) {
    judge_held(echo_.release(), now);  // it has begun to answer, or it was nothing
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
