// SPDX-License-Identifier: Apache-2.0
#include "bus/rtu_framer.hpp"

#include <algorithm>

namespace mbgate::bus {
namespace {

constexpr unsigned kMaxNoise = 2;  // bytes that a driver's turning on may look like
using Kind = modbus::PduLength::Kind;

}  // namespace

RtuFramer::RtuFramer(const modbus::RtuTiming& timing, BusCounters& counters)
    : timing_(timing), silence_(std::max(timing.t3_5(), kAdapterSlack)), counters_(counters) {}

void RtuFramer::expect(const Transaction& transaction) {
  listen();
  transaction_ = &transaction;
  response_.reset();
}

void RtuFramer::listen() {
  give_up_buffer();
  transaction_ = nullptr;
  begun_at_.reset();
  noise_skipped_ = 0;
  discarding_ = bad_crc_ = opaque_ = false;
}

// Silence, or a new question, has ended what stands here. It may have been a frame whose length
// cannot be known, such as another client's request.
void RtuFramer::give_up_buffer() {
  if (modbus::decode_rtu(buffered())) {
    note_stray(buffered());
  } else {
    counters_.stray_bytes += buffer_.size();
  }
  buffer_.clear();
}

void RtuFramer::note_stray(modbus::Bytes frame) {
  ++counters_.stray_frames;
  const modbus::PduLength length = modbus::response_length(frame.subspan(1));
  strays_.add({frame[0],
               length.kind == Kind::known && length.bytes + modbus::kRtuOverhead == frame.size()});
}

// What stands here is not the answer. It is kept until silence tells what it was.
void RtuFramer::discard() {
  begun_at_.reset();
  discarding_ = true;
  bad_crc_ = opaque_ = false;
}

Verdict RtuFramer::add(modbus::Bytes bytes, Instant now) {
  const bool silence_before = now - last_byte_ >= timing_.t3_5();
  last_byte_ = now;
  if (silence_before && !begun_at_) {
    // What stands here was not the answer, and a new frame begins.
    give_up_buffer();
    noise_skipped_ = 0;
    discarding_ = false;
  }
  if (buffer_.size() + bytes.size() > buffer_.capacity()) {
    counters_.stray_bytes += buffer_.size() + bytes.size();
    buffer_.clear();
    discard();
    return Verdict::none;
  }
  buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
  if (bad_crc_ || discarding_) {
    discard();
    return Verdict::none;
  }
  return search(now);
}

Verdict RtuFramer::again(Instant now) {
  response_.reset();
  return search(now);
}

Verdict RtuFramer::search(Instant now) {
  for (;;) {
    switch (look(now)) {
      case Step::wait: return Verdict::none;
      case Step::response: return Verdict::response;
      case Step::again: break;
    }
  }
}

void RtuFramer::skip_noise() {
  while (transaction_ != nullptr && !buffer_.empty() && noise_skipped_ < kMaxNoise &&
         buffer_[0] != transaction_->address && (buffer_[0] == 0x00 || buffer_[0] == 0xFF)) {
    buffer_.erase(buffer_.begin());
    ++noise_skipped_;
    ++counters_.noise_bytes;
  }
}

void RtuFramer::drop(std::size_t bytes) {
  buffer_.erase(buffer_.begin(), buffer_.begin() + static_cast<std::ptrdiff_t>(bytes));
  begun_at_.reset();
  noise_skipped_ = 0;
  opaque_ = false;
}

RtuFramer::Step RtuFramer::look(Instant now) {
  skip_noise();
  if (buffer_.empty()) {
    return Step::wait;
  }
  const bool right_unit = transaction_ != nullptr && buffer_[0] == transaction_->address;
  if (buffer_.size() == 1) {
    if (right_unit && !begun_at_) {
      begun_at_ = now;
    }
    return Step::wait;
  }
  const bool right_function =
      right_unit && (buffer_[1] & ~modbus::kExceptionBit) == transaction_->request.function();
  if (!right_function || has_other_length()) {
    begun_at_.reset();
    return look_at_stranger();
  }
  if (!begun_at_) {
    begun_at_ = now;
  }
  return look_at_candidate();
}

modbus::PduLength RtuFramer::candidate_length() const {
  const modbus::PduLength own = modbus::response_length(buffered().subspan(1));
  return own.kind == Kind::opaque ? modbus::expected_response_length(transaction_->request) : own;
}

// Its byte count says already that it is no answer to what was asked.
bool RtuFramer::has_other_length() const {
  const modbus::PduLength own = modbus::response_length(buffered().subspan(1));
  const modbus::PduLength expected = modbus::expected_response_length(transaction_->request);
  return own.kind == Kind::known && expected.kind == Kind::known && own.bytes != expected.bytes &&
         (buffer_[1] & modbus::kExceptionBit) == 0;
}

RtuFramer::Step RtuFramer::look_at_candidate() {
  const modbus::PduLength length = candidate_length();
  if (length.kind != Kind::known) {
    opaque_ = length.kind == Kind::opaque;
    return Step::wait;
  }
  const std::size_t size = length.bytes + modbus::kRtuOverhead;
  if (size > modbus::kMaxRtuSize) {
    discard();
    return Step::wait;
  }
  if (buffer_.size() < size) {
    return Step::wait;
  }
  const modbus::Bytes frame = buffered().first(size);
  const modbus::Bytes pdu = frame.subspan(1, length.bytes);
  const auto fit = modbus::check_response(transaction_->request, pdu);
  if (!modbus::has_good_crc(frame)) {
    if (buffer_.size() == size && fit != modbus::ResponseFit::wrong_length) {
      bad_crc_ = true;
    } else {
      discard();
    }
    return Step::wait;
  }
  if (fit == modbus::ResponseFit::normal || fit == modbus::ResponseFit::exception) {
    accept(pdu);
    drop(size);
    return Step::response;
  }
  note_stray(buffered().first(size));
  drop(size);
  return Step::again;
}

void RtuFramer::accept(modbus::Bytes pdu) {
  response_ = modbus::Pdu::from(pdu);
  response_began_ = *begun_at_;
}

RtuFramer::Step RtuFramer::look_at_stranger() {
  const modbus::PduLength length = modbus::response_length(buffered().subspan(1));
  const std::size_t size = length.bytes + modbus::kRtuOverhead;
  if (length.kind != Kind::known || buffer_.size() < size) {
    return Step::wait;
  }
  if (!modbus::has_good_crc(buffered().first(size))) {
    discard();
    return Step::wait;
  }
  note_stray(buffered().first(size));
  drop(size);
  return Step::again;
}

std::optional<Instant> RtuFramer::next_deadline() const {
  if (!begun_at_) {
    return std::nullopt;
  }
  if (awaits_silence()) {
    return last_byte_ + silence_;
  }
  const modbus::PduLength length = buffer_.size() < 2
                                       ? modbus::expected_response_length(transaction_->request)
                                       : candidate_length();
  const std::size_t size =
      length.kind == Kind::known ? length.bytes + modbus::kRtuOverhead : modbus::kMaxRtuSize;
  return *begun_at_ + timing_.duration_of(size) + kAdapterSlack;
}

Verdict RtuFramer::handle_deadline(Instant now) {
  const auto deadline = next_deadline();
  if (!deadline || now < *deadline) {
    return Verdict::none;
  }
  if (bad_crc_) {
    return Verdict::damaged;
  }
  if (opaque_) {
    return end_by_silence();
  }
  discard();
  return Verdict::none;
}

Verdict RtuFramer::end_by_silence() {
  const auto frame = modbus::decode_rtu(buffered());
  if (!frame) {
    return Verdict::damaged;
  }
  const auto fit = modbus::check_response(transaction_->request, frame->pdu.bytes());
  if (fit != modbus::ResponseFit::normal && fit != modbus::ResponseFit::exception) {
    note_stray(buffered());
    drop(buffer_.size());
    return Verdict::none;
  }
  accept(frame->pdu.bytes());
  drop(buffer_.size());
  return Verdict::response;
}

}  // namespace mbgate::bus
