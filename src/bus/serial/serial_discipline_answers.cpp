// SPDX-License-Identifier: Apache-2.0
// Whether what a line has brought is the answer: not what is owed, what is an echo, or what came
// before it can have been one.
#include <algorithm>
#include <utility>

#include "bus/serial/serial_discipline.hpp"

namespace mbgate::bus {
namespace {

// A USB adapter may keep an echo for so long (its latency timer, and a busy host).
constexpr Duration kEchoKept = std::chrono::milliseconds(20);

// With zeros behind it, such as a driver makes that turns off, the echo of a request without fields
// is a good frame: the CRC of what ends in its own CRC is 0, and zeros leave it so. Its data begin
// with the CRC of the request.
bool begins_as_echo(const Echo& echo, const Framer& framer, const Transaction& asked) {
  const modbus::Bytes request = asked.request.pdu().bytes();
  const modbus::Bytes response = framer.response().bytes();
  if (!echo.is_learned() || echo.noticed() == NoticedEcho::found ||
      response.size() <= request.size() ||
      !std::ranges::equal(request, response.first(request.size()))) {
    return false;
  }
  const FrameBytes sent = framer.encode(asked.address, asked.request.pdu());
  const FrameBytes came = framer.encode(asked.address, framer.response());
  return std::equal(sent.begin(), sent.end(), came.begin());
}

}  // namespace

void SerialDiscipline::judge_held(const Echo::Held& held, Instant now) {
  for (auto piece = held.pieces.begin(); piece != held.pieces.end(); ++piece) {
    const auto next = std::next(piece);
    const std::size_t end = next == held.pieces.end() ? held.bytes.size() : next->begin;
    judge(framer_.add({held.bytes.data() + piece->begin, end - piece->begin}, piece->came), now);
  }
}

// It may be a late echo; what begins before the request has left a paced line answers nothing; and
// it may be the answer to an earlier request.
Verdict SerialDiscipline::refuse_others(Verdict verdict, Instant now) {
  const auto is_no_answer = [this] {
    const auto first = first_fit(owed_, framer_.response());
    return echo_.is_owed(framer_.response()) || begins_as_echo(echo_, framer_, *transaction_) ||
           (paced_ && framer_.found().began < silence_.emission_ends()) ||
           (first != owed_.end() && !first->is_own_answer(framer_.response()));
  };
  while (verdict == Verdict::response && is_no_answer()) {
    verdict = refuse(now);
  }
  return verdict;
}

Verdict SerialDiscipline::refuse(Instant now) {
  const bool is_echo_of_now = paced_ && framer_.found().began < silence_.emission_ends() &&
                              echo_.is_repetition(framer_.response());
  const bool proves_echo = owed_.empty() && echo_.is_unknown();
  if (echo_.take_owed(framer_.response()) || begins_as_echo(echo_, framer_, *transaction_)) {
    ++counters_.unsolicited_frames;
  } else if (echo_.is_learned() && echo_.is_repetition(framer_.response()) &&
             (owed_.empty() || echo_.is_unknown()) && !echo_.pass(proves_echo)) {
    if (!proves_echo) {
      ++counters_.unsolicited_frames;  // an echo, or what is owed: that stays owed
      may_be_echo_ = echo_.is_unknown() && !transaction_->request.is_read();
    }
  } else if (const auto first = first_fit(owed_, framer_.response());
             first != owed_.end() && !is_echo_of_now) {
    owed_.erase(first);
    refused_.add({transaction_->address, framer_.response(), now});
  } else {
    ++counters_.unsolicited_frames;
    if (transaction_->request.is_read() && !std::exchange(unpaced_reported_, true)) {
      faults_.add(LineFault::answered_while_sending);
    }
  }
  return framer_.again(now);
}

// Until a read has shown whether the line hears itself, a repetition that comes at once may be an
// echo. If something else that fits stands behind it, it was; alone it is taken, but only from a
// device that is known to be there. Whether there is an echo this does not show: a device that
// answers twice may have said both.
Verdict SerialDiscipline::settle_echo(Verdict verdict, Instant now) {
  // It was shown that this line hears itself; or it is a read, whose answer hardly looks so; or
  // nothing shows that there is a device.
  const bool is_nobodys = !echo_.has_heard_device();
  const bool is_echo = echo_.was_shown() || transaction_->request.is_read() || is_nobodys;
  const bool is_late = framer_.found().began > silence_.emission_ends() + kEchoKept;
  if (!echo_.is_unknown() || !echo_.is_repetition(framer_.response()) || (is_late && !is_echo)) {
    return verdict;
  }
  if (echo_.pass()) {
    return verdict;  // two came, and only one of them can be the echo
  }
  if (is_echo) {
    const Verdict behind = refuse_others(framer_.again(now), now);
    if (is_nobodys && behind == Verdict::none && echo_.is_unknown()) {
      may_be_echo_ = !transaction_->request.is_read();
      echo_.note_unproven();
    }
    return behind;
  }
  const modbus::Pdu repetition = framer_.response();
  if (owed_.empty() && framer_.again(now) == Verdict::response) {
    return Verdict::response;
  }
  echo_.note_unproven();
  transaction_->response = repetition;
  end(LineEnd::How::response);
  return Verdict::none;
}

void SerialDiscipline::judge(Verdict verdict, Instant now) {
  verdict = refuse_others(verdict, now);
  if (verdict == Verdict::response) {
    verdict = settle_echo(verdict, now);
  }
  switch (verdict) {
    case Verdict::none: return;
    case Verdict::response: {
      // The answer to an earlier try may come before the echo of this one.
      const bool shows_no_echo =
          echo_.note_answered(framer_.response(), framer_.found().came_first && owed_.empty());
      transaction_->response = framer_.response();
      end(LineEnd::How::response);
      end_->shows_no_echo = shows_no_echo;
      return;
    }
    case Verdict::damaged:
      draining_ = true;
      end(LineEnd::How::damaged);
      return;
  }
}

}  // namespace mbgate::bus
