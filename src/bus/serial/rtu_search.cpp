// SPDX-License-Identifier: Apache-2.0
#include "bus/serial/rtu_search.hpp"

#include <algorithm>

#include "bus/serial/rtu_shape.hpp"

namespace mbgate::bus {
namespace {

using Kind = modbus::PduLength::Kind;
using What = RtuFind::What;
using modbus::ResponseFit;

RtuFind answer_at(std::size_t at, Answer how) { return {What::answer, at, 0, how}; }

// If silence is all that follows, it is none.
RtuFind incomplete_at(std::size_t at, bool silence) {
  return silence ? RtuFind{} : answer_at(at, Answer::incomplete);
}

}  // namespace

// Nothing: no frame begins here, whatever may come.
RtuFind RtuSearch::look(bool silence) const {
  Place place{.silence = silence};
  // Were a bit of another client's request wrong, the answer to it would stand behind noise.
  const std::size_t most =
      transaction_ == nullptr
          ? kMostNoise
          : std::min(kMostNoise, transaction_->request.pdu().size() + modbus::kRtuOverhead - 1);
  for (; place.at < received_.size() && place.at <= most; ++place.at) {
    const RtuFind find = look_at(place);
    if (find.what == What::unfinished) {
      place.unfinished = true;
    } else if (find.what != What::nothing) {
      return find;
    }
  }
  const bool more_may_come = place.unfinished || (received_.size() <= most && !silence);
  return {more_may_come ? What::unfinished : What::nothing};
}

RtuFind RtuSearch::look_at(const Place& place) const {
  const modbus::Bytes bytes = bytes_from(place.at);
  const bool right_unit = transaction_ != nullptr && bytes[0] == transaction_->address;
  if (bytes.size() == 1) {
    return right_unit ? incomplete_at(place.at, place.silence) : RtuFind{What::unfinished};
  }
  if (right_unit && may_begin_answer(place.at)) {
    const RtuFind find = look_at_candidate(place);
    if (find.what != What::nothing) {
      return find;
    }
  }
  return look_at_stranger(place);
}

bool RtuSearch::is_beginning_of_answer() const {
  if (!may_begin_answer(0)) {
    return false;
  }
  const RtuFind find = look_at_candidate({});
  return find.what != What::nothing && find.answer != Answer::bad_crc;
}

// Its function is right, and its byte count does not say already that it is no answer to what was
// asked.
bool RtuSearch::may_begin_answer(std::size_t at) const {
  const modbus::Bytes bytes = bytes_from(at);
  if (transaction_ == nullptr || bytes.size() < 2 || bytes[0] != transaction_->address ||
      (bytes[1] & ~modbus::kExceptionBit) != transaction_->request.function()) {
    return false;
  }
  const modbus::PduLength expected = modbus::expected_response_length(transaction_->request);
  if (is_exception(bytes)) {
    return at == 0 || expected.kind != Kind::opaque;
  }
  const modbus::PduLength own = modbus::response_length(bytes.subspan(1));
  if (own.kind == Kind::opaque && expected.kind == Kind::opaque) {
    return at == 0;
  }
  return own.kind != Kind::known || expected.kind != Kind::known || own.bytes == expected.bytes;
}

modbus::PduLength RtuSearch::length_of(modbus::Bytes answer) const {
  if (answer.size() < 2) {
    return modbus::expected_response_length(transaction_->request);
  }
  const modbus::PduLength own = modbus::response_length(answer.subspan(1));
  if (own.kind == Kind::known) {
    return own;
  }
  const modbus::PduLength expected = modbus::expected_response_length(transaction_->request);
  return own.kind == Kind::need_more && expected.kind != Kind::known ? own : expected;
}

// The answer may have begun here.
RtuFind RtuSearch::look_at_candidate(const Place& place) const {
  const modbus::Bytes bytes = bytes_from(place.at);
  const modbus::PduLength length = length_of(bytes);
  if (length.kind != Kind::known) {
    return length.kind == Kind::opaque ? answer_at(place.at, Answer::opaque)
                                       : incomplete_at(place.at, place.silence);
  }
  const std::size_t size = length.bytes + modbus::kRtuOverhead;
  if (size > modbus::kMaxRtuSize) {
    return {};
  }
  if (bytes.size() < size) {
    return incomplete_at(place.at, place.silence);
  }
  const ResponseFit fit =
      modbus::check_response(transaction_->request, bytes.subspan(1, length.bytes));
  if (!modbus::has_good_crc(bytes.first(size))) {
    const bool complete = bytes.size() == size && fit != ResponseFit::wrong_length;
    return complete ? answer_at(place.at, Answer::bad_crc) : RtuFind{};
  }
  const bool short_one = place.at > 0 && is_exception(bytes);
  if (short_one && bytes.size() > size) {
    return {};
  }
  if ((place.unfinished || short_one) && !place.silence) {
    return answer_at(place.at, Answer::unsure);
  }
  if (!is_fitting(fit)) {
    return {What::other, place.at, size};
  }
  return look_at_echo(place, size).value_or(RtuFind{What::response, place.at, size});
}

// The echo of what was sent may begin with what looks like the answer, of so many bytes: whether
// its rest follows tells them apart.
std::optional<RtuFind> RtuSearch::look_at_echo(const Place& place, std::size_t size) const {
  const modbus::Pdu& asked = transaction_->request.pdu();
  if (size >= asked.size() + modbus::kRtuOverhead) {
    return std::nullopt;
  }
  const modbus::RtuBytes sent = modbus::encode_rtu(transaction_->address, asked);
  const modbus::Bytes bytes = bytes_from(place.at);
  const std::size_t count = std::min(bytes.size(), sent.size());
  if (!std::ranges::equal(bytes.first(count), modbus::Bytes(sent).first(count))) {
    return std::nullopt;
  }
  if (count == sent.size()) {
    return RtuFind{What::echo, place.at, count};
  }
  return place.silence ? std::nullopt : std::optional(answer_at(place.at, Answer::unsure));
}

bool RtuSearch::is_echo(std::uint8_t address, modbus::Bytes pdu, Instant last) const {
  return transaction_ != nullptr && address == transaction_->address &&
         last < sent_ + timing_.duration_of(pdu.size() + modbus::kRtuOverhead) &&
         std::ranges::equal(pdu, transaction_->request.pdu().bytes());
}

// A frame that is no answer, perhaps of another unit.
RtuFind RtuSearch::look_at_stranger(const Place& place) const {
  const modbus::Bytes bytes = bytes_from(place.at);
  if (place.at > 0 && is_exception(bytes)) {
    return {};  // so short that anything may look like it
  }
  if (const auto frame = good_frame(bytes)) {
    if (place.unfinished && !place.silence) {
      return {};  // it may be a part of what has begun further ahead
    }
    const bool asks = !frame->is_response &&
                      !is_echo(bytes[0], bytes.subspan(1, frame->size - modbus::kRtuOverhead),
                               received_.came_at(place.at + frame->size - 1));
    return {asks ? What::request : What::other, place.at, frame->size};
  }
  return {!place.silence && may_begin_frame(bytes) ? What::unfinished : What::nothing};
}

}  // namespace mbgate::bus
