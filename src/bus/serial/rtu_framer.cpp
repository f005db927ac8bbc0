// SPDX-License-Identifier: Apache-2.0
#include "bus/serial/rtu_framer.hpp"

#include <algorithm>

#include "bus/serial/rtu_shape.hpp"

namespace mbgate::bus {

void RtuFramer::expect(const Transaction& transaction, Instant sent) {
  listen();
  transaction_ = &transaction;
  sent_ = sent;
  hurried_.reset();
  given_ = 0;
  found_.pdu.reset();
}

void RtuFramer::listen() {
  give_up_buffer();
  transaction_ = nullptr;
  answer_ = Answer::not_begun;
  discarding_ = false;
}

void RtuFramer::forget() {
  listen();
  cut_ = {};
}

// Silence, or a new question, has ended what stands here. It may have been a frame whose length
// cannot be known, such as another client's request; not the beginning of one that is longer.
void RtuFramer::give_up_buffer() {
  const bool is_reported = !std::exchange(answers_another_, false);
  if (buffer_.size() == 0) {
    return;
  }
  const auto whole = buffer_.size() > 1 ? good_frame(buffer_.bytes()) : std::nullopt;
  const bool is_response = whole && whole->is_response && whole->size == buffer_.size();
  if (is_reported && modbus::decode_rtu(buffer_.bytes()) &&
      (is_response || !may_begin_frame(buffer_.bytes()))) {
    note_unsolicited(0, buffer_.size());
  } else {
    counters_.stray_bytes += buffer_.size();
    if (is_reported) {
      cut_.keep(buffer_.bytes(), buffer_.came_at(0), buffer_.came_at(buffer_.size() - 1));
    }
  }
  buffer_.clear();
}

// The rest of a frame whose beginning was given up.
void RtuFramer::join_cut() {
  if (buffer_.size() == 0) {
    return;
  }
  if (const auto joined = cut_.complete(buffer_.bytes(), buffer_.came_at(0))) {
    const modbus::RtuAdu& frame = joined->frame;
    const Instant came = buffer_.came_at(joined->taken - 1);
    ++counters_.unsolicited_frames;
    UnsolicitedFrame unsolicited{frame.address, frame.pdu, came, joined->after_noise};
    unsolicited.pause = joined->pause > slack_ ? joined->pause : Duration{0};
    unsolicited_.add(unsolicited);
    discarding_ = answers_another_ =
        !joined->is_response && !looker().is_echo(frame.address, frame.pdu.bytes(), came);
    buffer_.drop(joined->taken);
    answer_ = Answer::not_begun;
  }
}

bool RtuFramer::is_amid_frame() const {
  if (buffer_.size() < (is_behind_frame_ ? 2U : 1U)) {
    return buffer_.size() == 0 && cut_.ends_at(last_byte_);
  }
  return (!discarding_ && may_begin_frame(buffer_.bytes())) ||
         cut_.may_go_on(buffer_.bytes(), buffer_.came_at(0), slack_);
}

void RtuFramer::note_unsolicited(std::size_t at, std::size_t size) {
  ++counters_.unsolicited_frames;
  const modbus::Bytes frame = buffer_.bytes().subspan(at, size);
  const modbus::Bytes pdu = frame.subspan(1, size - modbus::kRtuOverhead);
  unsolicited_.add({frame[0], *modbus::Pdu::from(pdu), buffer_.came_at(at + size - 1), at > 0});
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
    discarding_ = is_behind_frame_ = false;
  } else if (silence_before && answer_ == Answer::incomplete) {
    // Nor was what stands before it a part of anything.
    counters_.stray_bytes += answer_at_;
    if (answer_at_ > 0) {
      cut_.keep(buffer_.bytes().first(answer_at_), buffer_.came_at(0),
                buffer_.came_at(answer_at_ - 1));
    }
    buffer_.drop(answer_at_);
  }
  if (!buffer_.add(bytes, now)) {
    counters_.stray_bytes += buffer_.size() + bytes.size();
    buffer_.clear();
    discard();
  }
  // A cut frame that has lost its last byte must not take that from the answer.
  if (!cut_.empty() && !looker().is_beginning_of_answer()) {
    join_cut();
  }
  return discarding_ ? Verdict::none : search(false);
}

Verdict RtuFramer::again(Instant /*now*/) {
  found_.pdu.reset();
  return search(false);
}

// Another client's request is a frame too: what comes behind it, without a silence, answers that.
Verdict RtuFramer::search(bool silence) {
  for (;;) {
    const RtuFind find = looker().look(silence);
    answer_ = find.answer;
    switch (find.what) {
      case RtuFind::What::response: accept(find); return Verdict::response;
      case RtuFind::What::answer: answer_at_ = find.at; return Verdict::none;
      case RtuFind::What::unfinished: return Verdict::none;
      case RtuFind::What::nothing: discard(); return Verdict::none;
      case RtuFind::What::other: consume(find.at, find.size); break;
      case RtuFind::What::request:
        consume(find.at, find.size);
        discarding_ = answers_another_ = true;
        return Verdict::none;
      case RtuFind::What::echo:
        counters_.stray_bytes += find.at + find.size;
        buffer_.drop(find.at + find.size);
        break;
    }
  }
}

void RtuFramer::accept(const RtuFind& response) {
  Instant began = buffer_.came_at(response.at);
  const bool is_paced = sent_ != Instant::min();
  for (std::size_t byte = 0; is_paced && byte < response.size; ++byte) {
    began =
        std::min(began, buffer_.came_at(response.at + byte) - timing_.least_duration_of(byte + 1));
  }
  found_ = {modbus::Pdu::from(
                buffer_.bytes().subspan(response.at + 1, response.size - modbus::kRtuOverhead)),
            began, response.at == 0 && buffer_.size() == given_, response.at};
  counters_.noise_bytes += response.at;
  buffer_.drop(response.at + response.size);
  is_behind_frame_ = true;
}

void RtuFramer::consume(std::size_t at, std::size_t size) {
  note_unsolicited(at, size);
  counters_.noise_bytes += at;
  buffer_.drop(at + size);
  is_behind_frame_ = true;
}

std::optional<Instant> RtuFramer::next_deadline() const {
  if (!in_progress()) {
    // Perhaps a frame of the device that was asked, whose length nothing predicts.
    const bool may_be_misfit = !answers_another_ && transaction_ != nullptr &&
                               buffer_.size() > modbus::kRtuOverhead &&
                               buffer_.bytes()[0] == transaction_->address;
    return may_be_misfit ? std::optional(last_byte_ + slack_) : std::nullopt;
  }
  const modbus::PduLength length = looker().length_of(buffer_.bytes().subspan(answer_at_));
  const std::size_t size = length.kind == modbus::PduLength::Kind::known
                               ? length.bytes + modbus::kRtuOverhead
                               : modbus::kMaxRtuSize;
  const Instant whole = buffer_.came_at(answer_at_) + timing_.duration_of(size);
  const Instant latest = hurried_ ? std::max(*hurried_, whole + slack_) : whole + kLongestPauses;
  return std::min((awaits_silence() ? last_byte_ : std::max(whole, last_byte_)) + slack_, latest);
}

Verdict RtuFramer::handle_deadline(Instant now) {
  // The silence behind an answer that is given up may be over too.
  for (auto due = next_deadline(); due && now >= *due; due = next_deadline()) {
    if (!in_progress()) {
      if (modbus::decode_rtu(buffer_.bytes())) {
        consume(0, buffer_.size());
      }
      give_up_buffer();
      discarding_ = false;
      return Verdict::none;
    }
    if (answer_ == Answer::opaque) {
      return end_by_silence();
    }
    if (answer_ == Answer::unsure && search(true) == Verdict::response) {
      return Verdict::response;
    }
    if (answer_ == Answer::bad_crc) {
      found_.noise = answer_at_;
      counters_.noise_bytes += answer_at_;
      buffer_.drop(answer_at_);
      return Verdict::damaged;
    }
    discard();
    join_cut();
  }
  return Verdict::none;
}

Verdict RtuFramer::end_by_silence() {
  const auto frame = modbus::decode_rtu(buffer_.bytes());
  if (!frame) {
    found_.noise = 0;
    return Verdict::damaged;
  }
  if (is_fitting(modbus::check_response(transaction_->request, frame->pdu.bytes()))) {
    accept({RtuFind::What::response, 0, buffer_.size()});
    return Verdict::response;
  }
  consume(0, buffer_.size());
  answer_ = Answer::not_begun;
  return Verdict::none;
}

}  // namespace mbgate::bus
