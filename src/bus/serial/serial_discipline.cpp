// SPDX-License-Identifier: Apache-2.0
#include "bus/serial/serial_discipline.hpp"

#include <algorithm>
#include <utility>
#include <vector>

#include "base/assert.hpp"

namespace mbgate::bus {
namespace {

// Less than this is no proof: clocks differ, and so does what a drive counts its wait from.
constexpr int kEarlyPart = 8;  // of the response wait

// A driver, and the bus that its adapter is on, may begin a frame so much later than it was given.
constexpr Duration kDriverIsLate = std::chrono::milliseconds(20);

// Some drives' form of a broadcast has function codes of its own.
modbus::Pdu pdu_on_wire(const Transaction& transaction) {
  const modbus::Pdu& pdu = transaction.request.pdu();
  if (!transaction.broadcast || transaction.broadcast->function_or == 0) {
    return pdu;
  }
  std::vector<std::uint8_t> bytes(pdu.bytes().begin(), pdu.bytes().end());
  bytes.front() = static_cast<std::uint8_t>(pdu.function() | transaction.broadcast->function_or);
  return *modbus::Pdu::from(bytes);
}

// What has begun in time is complete so long after the end of the wait. An answer that begins anew
// and anew is none.
Duration longest_rest(const BusSettings& settings, bool is_hurried) {
  return longest_stream(settings) +
         (is_hurried ? settings.frame_slack_or_default() : kLongestPauses);
}

}  // namespace

SerialDiscipline::SerialDiscipline(const BusSettings& settings, BusCounters& counters)
    : settings_(settings),
      silence_(settings),
      counters_(counters),
      echo_(settings.line.echo, counters, faults_),
      framer_(settings, silence_.timing(), counters) {}

void SerialDiscipline::open(Instant now, LineKind kind, Instant listen_until) {
  abort();
  framer_.forget();
  paced_ = settings_.line.paced.value_or(kind == LineKind::uart);
  echo_.open();
  unpaced_reported_ = is_answerless_ = false;
  unsent_ = 0;
  silence_.open(now, listen_until);
}

void SerialDiscipline::update() {
  framer_.update(settings_);
  silence_.note_pause(framer_.is_amid_frame());
}

FrameBytes SerialDiscipline::begin(Transaction& transaction, const drive::DeviceTiming& timing,
                                   OwedAnswers owed, Instant now) {
  MBGATE_ASSERT(transaction_ == nullptr, "a serial line has one transaction at a time");
  MBGATE_ASSERT(now >= silence_.possible_at(), "nothing is transmitted into an own frame");
  judge_held(echo_.release(), now);  // the beginning of a late answer, if its rest comes
  const FrameBytes frame = framer_.encode(transaction.address, pdu_on_wire(transaction));
  transaction_ = &transaction;
  end_.reset();
  silence_.note_frame(frame.size(), now);
  response_wait_ = timing.response_wait;
  owed_ = std::move(owed);
  misfit_ = may_be_echo_ = is_hurried_ = false;
  draining_ = false;
  const Duration answer_time =
      transaction.boot_time ? settings_.turnaround : timing.response_timeout + timing.response_wait;
  is_answerless_ = transaction.is_broadcast() || transaction.may_stay_silent();
  response_due_ = silence_.emission_ends() + answer_time;
  response_deadline_ = response_due_;
  heard_ = 0;
  echo_.expect(transaction, frame, now, response_due_);
  if (transaction.is_broadcast()) {
    silence_.note_broadcast();
    framer_.listen();
  } else {
    framer_.expect(transaction, paced_ ? silence_.emission_ends() : Instant::min());
  }
  return frame;
}

void SerialDiscipline::limit_wait(const Transaction& /*transaction*/, Duration longest) {
  is_hurried_ = true;
  response_deadline_ = std::min(response_deadline_, silence_.emission_ends() + longest);
  framer_.hurry(response_deadline_);
}

bool SerialDiscipline::handle_looked(Instant now) {
  if (transaction_ == nullptr && silence_.is_silent(now)) {
    framer_.listen();  // what only silence ends, before it is counted what is owed
  }
  const bool is_over =
      transaction_ == nullptr ? is_answerless_ : now >= response_due_ && !framer_.in_progress();
  if (unsent_ == 0 || !is_over || now < silence_.emission_ends() + kDriverIsLate) {
    return false;
  }
  faults_.add(LineFault::driver_stalled);
  return true;
}

void SerialDiscipline::take_misfit(const modbus::Pdu& frame, std::optional<Instant> over) {
  if (transaction_ == nullptr || transaction_->is_broadcast()) {
    return;
  }
  if (over) {
    misfit_ = true;
    limit_wait(*transaction_, std::max(*over - silence_.emission_ends(), Duration{0}));
  } else {
    transaction_->response = frame;
    end(LineEnd::How::response);
    end_->early = false;  // the framer's times are those of an earlier frame
    end_->noise = 0;
  }
}

void SerialDiscipline::abort() {
  framer_.listen();
  transaction_ = nullptr;
  end_.reset();
}

void SerialDiscipline::end(LineEnd::How how) {
  const Instant answers_at =
      silence_.emission_ends() + response_wait_ - response_wait_ / kEarlyPart;
  const bool early = how == LineEnd::How::response && response_wait_ > Duration{0} &&
                     framer_.found().began < answers_at;
  end_ = LineEnd{how, std::exchange(transaction_, nullptr), response_due_,
                 std::max(silence_.quiet_since() - silence_.emission_ends(), Duration{0}), early};
  const bool framed = how == LineEnd::How::response || how == LineEnd::How::damaged;
  end_->heard = heard_;
  end_->heard_after = heard_ > 0 ? heard_at_ - silence_.emission_ends() : Duration{0};
  end_->noise = framed ? framer_.found().noise : 0;
  end_->may_be_echo = may_be_echo_;
  while (const auto before = framer_.take_unsolicited()) {
    refused_.add(*before);
  }
  framer_.listen();  // what stands behind it is taken after it
}

void SerialDiscipline::handle_bytes(modbus::Bytes bytes, Instant now) {
  if (framer_.awaits_silence()) {
    handle_deadline(now);  // if silence has ended a frame already, these bytes are no part of it
  }
  silence_.note_bytes(now);
  const Echo::Heard heard = echo_.take(bytes, now);
  judge_held(heard.held, now);
  bytes = heard.bytes;
  if (bytes.empty()) {  // of an echo, or of an answer that begins as one
    silence_.note_pause(echo_.is_unknown());
    return;
  }
  draining_ = draining_ || transaction_ == nullptr;
  if (transaction_ != nullptr && echo_.is_spoilt()) {
    counters_.stray_bytes += bytes.size();
    return;
  }
  if (now >= silence_.emission_ends()) {
    heard_at_ = heard_ == 0 ? now : heard_at_;
    heard_ += bytes.size();
  }
  judge(framer_.add(bytes, now), now);
  silence_.note_pause(framer_.is_amid_frame());
}

void SerialDiscipline::handle_deadline(Instant now) {
  if (handle_looked(now) || transaction_ == nullptr) {
    return;
  }
  if (transaction_->is_broadcast()) {
    if (now >= silence_.emission_ends()) {
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
  if (transaction_ != nullptr && now >= response_deadline_ &&
      (!framer_.in_progress() ||
       now >= response_deadline_ + longest_rest(settings_, is_hurried_))) {
    if (!transaction_->may_stay_silent() && !misfit_) {
      silence_.note_unanswered(now);
    }
    end(misfit_ ? LineEnd::How::misfit : LineEnd::How::no_response);
  }
}

std::optional<Instant> SerialDiscipline::next_deadline() const {
  if (transaction_ == nullptr) {
    return std::nullopt;
  }
  if (transaction_->is_broadcast()) {
    return silence_.emission_ends();
  }
  const auto of_frame = framer_.next_deadline();
  const Duration rest = framer_.in_progress() ? longest_rest(settings_, is_hurried_) : Duration{0};
  return earlier(of_frame, response_deadline_ + rest);
}

std::optional<UnsolicitedFrame> SerialDiscipline::take_unsolicited() {
  auto unsolicited = refused_.take();
  if (!unsolicited && !end_) {
    unsolicited = framer_.take_unsolicited();
    const bool is_of_asked =
        unsolicited && transaction_ != nullptr && unsolicited->address == transaction_->address;
    if (const auto late = is_of_asked ? first_fit(owed_, unsolicited->pdu) : owed_.end();
        late != owed_.end()) {
      owed_.erase(late);  // it has come, and is not owed any more
    }
  }
  if (unsolicited) {
    unsolicited->is_echo = echo_.is_of_read(unsolicited->address, unsolicited->pdu);
  }
  return unsolicited;
}

LineState SerialDiscipline::state(Instant now) const {
  if (transaction_ != nullptr) {
    return now < silence_.emission_ends() ? LineState::emission : LineState::waiting_for_reply;
  }
  if (silence_.is_listening(now)) {
    return LineState::initial;
  }
  if (silence_.is_in_turnaround(now)) {
    return LineState::waiting_turnaround_delay;
  }
  return draining_ && !silence_.is_silent(now) ? LineState::draining : LineState::idle;
}

}  // namespace mbgate::bus
