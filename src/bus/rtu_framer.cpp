// SPDX-License-Identifier: Apache-2.0
#include "bus/rtu_framer.hpp"

#include <algorithm>

#include "bus/rtu_shape.hpp"

namespace mbgate::bus {
namespace {

// Drivers that turn on, and what a line without bias picks up between two frames.
constexpr std::size_t kMostNoise = 8;
using Kind = modbus::PduLength::Kind;
using modbus::ResponseFit;

}  // namespace

RtuFramer::RtuFramer(const modbus::RtuTiming& timing, Duration slack, BusCounters& counters)
    : timing_(timing), slack_(slack), counters_(counters) {}

void RtuFramer::expect(const Transaction& transaction) {
  listen();
  transaction_ = &transaction;
  given_ = 0;
  response_.reset();
}

void RtuFramer::listen() {
  give_up_buffer();
  transaction_ = nullptr;
  answer_ = Answer::not_begun;
  discarding_ = false;
}

// Silence, or a new question, has ended what stands here. It may have been a frame whose length
// cannot be known, such as another client's request.
void RtuFramer::give_up_buffer() {
  if (!std::exchange(answers_another_, false) && modbus::decode_rtu(buffer_.bytes())) {
    note_stray(0, buffer_.size());
  } else {
    counters_.stray_bytes += buffer_.size();
  }
  buffer_.clear();
}

void RtuFramer::note_stray(std::size_t at, std::size_t size) {
  ++counters_.stray_frames;
  const modbus::Bytes pdu = bytes_from(at).subspan(1, size - modbus::kRtuOverhead);
  strays_.add({bytes_from(at)[0], *modbus::Pdu::from(pdu), buffer_.came_at(at + size - 1), at > 0});
}

// What stands here is not the answer. It is kept until silence tells what it was.
void RtuFramer::discard() {
  answer_ = Answer::not_begun;
  discarding_ = true;
}

Verdict RtuFramer::add(modbus::Bytes bytes, Instant now) {
  const bool silence_before = now - last_byte_ >= timing_.t3_5();
  last_byte_ = now;
  given_ += bytes.size();
  if (silence_before && !in_progress()) {
    // What stands here was not the answer, and a new frame begins.
    give_up_buffer();
    discarding_ = false;
  } else if (silence_before && answer_ == Answer::incomplete) {
    // Nor was what stands before it a part of anything.
    counters_.stray_bytes += answer_at_;
    buffer_.drop(answer_at_);
    answer_at_ = 0;
  }
  if (!buffer_.add(bytes, now)) {
    counters_.stray_bytes += buffer_.size() + bytes.size();
    buffer_.clear();
    discard();
  }
  return discarding_ ? Verdict::none : search(false);
}

Verdict RtuFramer::again(Instant /*now*/) {
  response_.reset();
  return search(false);
}

Verdict RtuFramer::search(bool silence) {
  for (;;) {
    answer_ = Answer::not_begun;
    switch (look(silence)) {
      case Found::response: return Verdict::response;
      case Found::consumed:
        if (discarding_) {
          return Verdict::none;
        }
        break;
      case Found::nothing: discard(); return Verdict::none;
      case Found::unfinished:
      case Found::answer: return Verdict::none;
    }
  }
}

// Nothing: no frame begins here, whatever may come.
RtuFramer::Found RtuFramer::look(bool silence) {
  Look look{.silence = silence};
  for (; look.at < buffer_.size() && look.at <= kMostNoise; ++look.at) {
    const Found found = look_at(look);
    if (found == Found::unfinished) {
      look.unfinished = true;
    } else if (found != Found::nothing) {
      return found;
    }
  }
  return look.unfinished || (buffer_.size() <= kMostNoise && !silence) ? Found::unfinished
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
  if ((bytes[1] & ~modbus::kExceptionBit) != transaction_->request.function()) {
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

modbus::PduLength RtuFramer::candidate_length(modbus::Bytes bytes) const {
  if (bytes.size() < 2) {
    return modbus::expected_response_length(transaction_->request);
  }
  const modbus::PduLength own = modbus::response_length(bytes.subspan(1));
  return own.kind == Kind::opaque ? modbus::expected_response_length(transaction_->request) : own;
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
  if (is_fitting(fit)) {
    return accept(look, size);
  }
  consume(look.at, size);
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
  note_stray(at, size);
  counters_.noise_bytes += at;
  buffer_.drop(at + size);
}

// A frame that is no answer, perhaps of another unit. Another client's request is one too: what
// comes behind it, without a silence, answers that.
RtuFramer::Found RtuFramer::look_at_stranger(const Look& look) {
  const modbus::Bytes bytes = bytes_from(look.at);
  if (look.at > 0 && is_exception(bytes)) {
    return Found::nothing;  // so short that anything may look like it
  }
  const modbus::PduLength response = modbus::response_length(bytes.subspan(1));
  const modbus::PduLength request = modbus::request_length(bytes.subspan(1));
  const bool good_response = is_good(bytes, response);
  if (good_response || is_good_request(bytes, request)) {
    if (look.unfinished && !look.silence) {
      return Found::nothing;  // it may be a part of what has begun further ahead
    }
    consume(look.at, (good_response ? response : request).bytes + modbus::kRtuOverhead);
    discarding_ = answers_another_ = !good_response;
    return Found::consumed;
  }
  // No device has such an address. The broadcast one is what noise looks like most often.
  const bool has_unit =
      bytes[0] != modbus::kBroadcastAddress && bytes[0] <= modbus::kMaxDeviceAddress;
  return has_unit && !look.silence &&
                 (may_become_whole(bytes, response) || may_become_whole(bytes, request))
             ? Found::unfinished
             : Found::nothing;
}

std::optional<Instant> RtuFramer::next_deadline() const {
  if (!in_progress()) {
    return std::nullopt;
  }
  if (awaits_silence()) {
    return last_byte_ + std::max(timing_.t3_5(), slack_);
  }
  const modbus::PduLength length = candidate_length(bytes_from(answer_at_));
  const std::size_t size =
      length.kind == Kind::known ? length.bytes + modbus::kRtuOverhead : modbus::kMaxRtuSize;
  return buffer_.came_at(answer_at_) + timing_.duration_of(size) + slack_;
}

Verdict RtuFramer::handle_deadline(Instant now) {
  const auto deadline = next_deadline();
  if (!deadline || now < *deadline) {
    return Verdict::none;
  }
  switch (answer_) {
    case Answer::opaque: return end_by_silence();
    case Answer::unsure:
      if (search(true) == Verdict::response) {
        return Verdict::response;
      }
      break;
    case Answer::not_begun:
    case Answer::incomplete:
    case Answer::bad_crc: break;
  }
  if (answer_ == Answer::bad_crc) {
    noise_ = answer_at_;
    counters_.noise_bytes += noise_;
    buffer_.drop(noise_);
    return Verdict::damaged;
  }
  discard();
  return Verdict::none;
}

Verdict RtuFramer::end_by_silence() {
  const auto frame = modbus::decode_rtu(buffer_.bytes());
  if (!frame) {
    noise_ = 0;
    return Verdict::damaged;
  }
  const Look whole{.silence = true};
  if (is_fitting(modbus::check_response(transaction_->request, frame->pdu.bytes()))) {
    accept(whole, buffer_.size());
    return Verdict::response;
  }
  consume(0, buffer_.size());
  answer_ = Answer::not_begun;
  return Verdict::none;
}

}  // namespace mbgate::bus
