// SPDX-License-Identifier: Apache-2.0
// What begins at a place among the bytes that came: the answer, another's frame, or nothing.
#include <algorithm>

#include "bus/rtu_framer.hpp"
#include "bus/rtu_shape.hpp"

namespace mbgate::bus {
namespace {

using Kind = modbus::PduLength::Kind;
using modbus::ResponseFit;

}  // namespace

// Were a bit of another client's request wrong, the answer to it would stand behind noise.
std::size_t RtuFramer::most_noise() const {
  return transaction_ == nullptr
             ? kMostNoise
             : std::min(kMostNoise, transaction_->request.pdu().size() + modbus::kRtuOverhead - 1);
}

// Nothing: no frame begins here, whatever may come.
RtuFramer::Found RtuFramer::look(bool silence) {
  Look look{.silence = silence};
  const std::size_t most = most_noise();
  for (; look.at < buffer_.size() && look.at <= most; ++look.at) {
    const Found found = look_at(look);
    if (found == Found::unfinished) {
      look.unfinished = true;
    } else if (found != Found::nothing) {
      return found;
    }
  }
  return look.unfinished || (buffer_.size() <= most && !silence) ? Found::unfinished
                                                                 : Found::nothing;
}

RtuFramer::Found RtuFramer::look_at(const Look& look) {
  const modbus::Bytes bytes = bytes_from(look.at);
  const bool right_unit = transaction_ != nullptr && bytes[0] == transaction_->address;
  if (bytes.size() == 1) {
    return right_unit ? found(look, Answer::incomplete) : Found::unfinished;
  }
  if (right_unit && may_begin_answer(look)) {
    const Found found = look_at_candidate(look);
    if (found != Found::nothing) {
      return found;
    }
  }
  return look_at_stranger(look);
}

// Its function is right, and its byte count does not say already that it is no answer to what was
// asked.
bool RtuFramer::may_begin_answer(const Look& look) const {
  const modbus::Bytes bytes = bytes_from(look.at);
  if (!has_asked_function(bytes)) {
    return false;
  }
  const modbus::PduLength expected = modbus::expected_response_length(transaction_->request);
  if (is_exception(bytes)) {
    return look.at == 0 || expected.kind != Kind::opaque;
  }
  const modbus::PduLength own = modbus::response_length(bytes.subspan(1));
  if (own.kind == Kind::opaque && expected.kind == Kind::opaque) {
    return look.at == 0;
  }
  return own.kind != Kind::known || expected.kind != Kind::known || own.bytes == expected.bytes;
}

// What has come says how long it is; or else what was asked does, while the byte count is missing
// too.
modbus::PduLength RtuFramer::candidate_length(modbus::Bytes bytes) const {
  if (bytes.size() < 2) {
    return modbus::expected_response_length(transaction_->request);
  }
  const modbus::PduLength own = modbus::response_length(bytes.subspan(1));
  if (own.kind == Kind::known) {
    return own;
  }
  const modbus::PduLength expected = modbus::expected_response_length(transaction_->request);
  return own.kind == Kind::need_more && expected.kind != Kind::known ? own : expected;
}

// The answer may have begun here. If silence is all that follows, what is incomplete is none.
RtuFramer::Found RtuFramer::found(const Look& look, Answer answer) {
  if (answer == Answer::incomplete && look.silence) {
    return Found::nothing;
  }
  answer_ = answer;
  answer_at_ = look.at;
  return Found::answer;
}

RtuFramer::Found RtuFramer::look_at_candidate(const Look& look) {
  const modbus::Bytes bytes = bytes_from(look.at);
  const modbus::PduLength length = candidate_length(bytes);
  if (length.kind != Kind::known) {
    return found(look, length.kind == Kind::opaque ? Answer::opaque : Answer::incomplete);
  }
  const std::size_t size = length.bytes + modbus::kRtuOverhead;
  if (size > modbus::kMaxRtuSize) {
    return Found::nothing;
  }
  if (bytes.size() < size) {
    return found(look, Answer::incomplete);
  }
  const ResponseFit fit =
      modbus::check_response(transaction_->request, bytes.subspan(1, length.bytes));
  if (!modbus::has_good_crc(bytes.first(size))) {
    const bool complete = bytes.size() == size && fit != ResponseFit::wrong_length;
    return complete ? found(look, Answer::bad_crc) : Found::nothing;
  }
  const bool short_one = look.at > 0 && is_exception(bytes);
  if (short_one && bytes.size() > size) {
    return Found::nothing;
  }
  if ((look.unfinished || short_one) && !look.silence) {
    return found(look, Answer::unsure);
  }
  if (!is_fitting(fit)) {
    consume(look.at, size);
    return Found::consumed;
  }
  const auto echo = look_at_echo(look, size);
  return echo ? *echo : accept(look, size);
}

// The echo of what was sent may begin with what looks like the answer, of so many bytes: whether
// its rest follows tells them apart.
std::optional<RtuFramer::Found> RtuFramer::look_at_echo(const Look& look, std::size_t size) {
  const modbus::Pdu& asked = transaction_->request.pdu();
  if (size >= asked.size() + modbus::kRtuOverhead) {
    return std::nullopt;
  }
  const modbus::RtuBytes sent = modbus::encode_rtu(transaction_->address, asked);
  const std::size_t count = std::min(buffer_.size() - look.at, sent.size());
  if (!std::ranges::equal(bytes_from(look.at).first(count), modbus::Bytes(sent).first(count))) {
    return std::nullopt;
  }
  if (count < sent.size()) {
    return look.silence ? std::nullopt : std::optional(found(look, Answer::unsure));
  }
  counters_.stray_bytes += look.at + count;
  buffer_.drop(look.at + count);
  return Found::consumed;
}

RtuFramer::Found RtuFramer::accept(const Look& look, std::size_t size) {
  response_ = modbus::Pdu::from(bytes_from(look.at).subspan(1, size - modbus::kRtuOverhead));
  response_began_ = buffer_.came_at(look.at);
  came_first_ = look.at == 0 && buffer_.size() == given_;
  noise_ = look.at;
  counters_.noise_bytes += look.at;
  buffer_.drop(look.at + size);
  answer_ = Answer::not_begun;
  return Found::response;
}

void RtuFramer::consume(std::size_t at, std::size_t size) {
  note_unsolicited(at, size);
  counters_.noise_bytes += at;
  buffer_.drop(at + size);
}

// What was sent itself: no later than this it has begun on the line, and by then nobody else had.
bool RtuFramer::is_echo(std::uint8_t address, modbus::Bytes pdu, Instant last) const {
  return transaction_ != nullptr && address == transaction_->address &&
         last < sent_ + timing_.duration_of(pdu.size() + modbus::kRtuOverhead) &&
         std::ranges::equal(pdu, transaction_->request.pdu().bytes());
}

// A frame that is no answer, perhaps of another unit. Another client's request is one too: what
// comes behind it, without a silence, answers that.
RtuFramer::Found RtuFramer::look_at_stranger(const Look& look) {
  const modbus::Bytes bytes = bytes_from(look.at);
  if (look.at > 0 && is_exception(bytes)) {
    return Found::nothing;  // so short that anything may look like it
  }
  if (const auto frame = good_frame(bytes)) {
    if (look.unfinished && !look.silence) {
      return Found::nothing;  // it may be a part of what has begun further ahead
    }
    const bool asks = !frame->is_response &&
                      !is_echo(bytes[0], bytes.subspan(1, frame->size - modbus::kRtuOverhead),
                               buffer_.came_at(look.at + frame->size - 1));
    consume(look.at, frame->size);
    discarding_ = answers_another_ = asks;
    return Found::consumed;
  }
  return !look.silence && may_begin_frame(bytes) ? Found::unfinished : Found::nothing;
}

}  // namespace mbgate::bus
