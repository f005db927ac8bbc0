// SPDX-License-Identifier: Apache-2.0
#include "bus/serial/echo.hpp"

#include <algorithm>
#include <utility>

#include "modbus/response.hpp"

namespace mbgate::bus {
namespace {

// After the response timeout, as answers (quarantine_max). What comes later cannot be excluded.
constexpr Duration kEchoOwed = std::chrono::seconds(10);

// Some may be lost; after so many reads in a row that were answered without one it is not known
// whether there is one.
constexpr unsigned kMostLost = 3;

// Can the echo of this be mistaken for the answer to it? Of 05, 06, 22 and 08/00 it always is one.
bool looks_like_answer(const Transaction& transaction) {
  const auto fit = modbus::check_response(transaction.request, transaction.request.pdu().bytes());
  return !transaction.is_broadcast() && fit == modbus::ResponseFit::normal;
}

// An answer to 07, 11, 12 or 17, which have no fields, may begin as the echo does: with data where
// that has its CRC. What comes then is neither an answer, nor does it say whether there is an echo.
bool shows_anything(const modbus::Pdu& asked) { return asked.size() > 1; }

}  // namespace

Echo::Echo(std::optional<bool> setting, BusCounters& counters, LineFaults& faults)
    : state_(!setting   ? State::unknown
             : *setting ? State::present
                        : State::absent),
      learns_(!setting),
      counters_(counters),
      faults_(faults) {}

void Echo::open() {
  forget();
  if (learns_ && !shown_) {
    state_ = State::unknown;
  }
  owed_.clear();
  asked_.reset();
  heard_.reset();
  may_answer_ = unproven_reported_ = false;
}

void Echo::forget() {
  expected_.clear();
  held_.clear();
  seen_ = 0;
}

void Echo::expect(const Transaction& transaction, const FrameBytes& frame, Instant now,
                  Instant due) {
  owe(now);
  due_ = due;
  forget();
  address_ = transaction.address;
  asked_ = transaction.request.pdu();
  may_answer_ = looks_like_answer(transaction);
  spoilt_ = passed_ = echoed_ = false;
  if (state_ == State::present || (learns_ && !may_answer_)) {
    expected_ = frame;
  }
}

// What was sent last, if nothing of its echo has come.
void Echo::owe(Instant now) {
  if (state_ != State::present || now > due_ + kEchoOwed) {
    owed_.clear();
    return;
  }
  if (!may_answer_ || seen_ > 0 || !is_awaited()) {
    return;
  }
  if (owed_.size() == owed_.capacity()) {
    owed_.erase(owed_.begin());
  }
  owed_.push_back(expected_);
}

Echo::Heard Echo::take(modbus::Bytes bytes, Instant now) {
  if (!is_awaited()) {
    return {{}, bytes};
  }
  return state_ == State::present ? compare(bytes) : look_for(bytes, now);
}

// How many of them are what comes next of the echo; nothing if one of them is not.
std::optional<std::size_t> Echo::matching(modbus::Bytes bytes) const {
  const std::size_t count = std::min(bytes.size(), expected_.size() - seen_);
  const auto next = expected_.begin() + static_cast<std::ptrdiff_t>(seen_);
  return std::ranges::equal(bytes.first(count), modbus::Bytes(&*next, count)) ? std::optional(count)
                                                                              : std::nullopt;
}

Echo::Heard Echo::compare(modbus::Bytes bytes) {
  if (const auto count = matching(bytes)) {
    seen_ += *count;
    if (!is_awaited()) {
      owed_.erase(owed_.begin(), std::ranges::find(owed_, expected_));
    }
    return {{}, bytes.subspan(*count)};
  }
  seen_ = expected_.size();
  spoilt_ = true;
  faults_.add(LineFault::echo_differed);
  if (learns_) {
    state_ = State::unknown;  // the next read shows again what it is
  }
  ++counters_.echo_mismatches;
  counters_.stray_bytes += bytes.size();
  return {};
}

// As long as what comes may be the echo of what was sent, it is held back: no answer to that should
// look so. One may all the same, so that only an answer behind it shows that the line hears itself.
Echo::Heard Echo::look_for(modbus::Bytes bytes, Instant now) {
  const auto count = matching(bytes);
  if (!count) {
    Held held = release();
    forget();
    return {held, bytes};
  }
  if (held_.size() < held_.capacity()) {
    held_.push_back({seen_, now});
  }
  seen_ += *count;
  echoed_ = !is_awaited() && shows_anything(*asked_);
  return {{}, bytes.subspan(*count)};
}

Echo::Held Echo::release() {
  Held held;
  if (state_ != State::present && seen_ > 0 && is_awaited()) {
    held = {{expected_.begin(), expected_.begin() + static_cast<std::ptrdiff_t>(seen_)}, held_};
    forget();
  }
  return held;
}

bool Echo::is_repetition(const modbus::Pdu& response) const {
  return may_answer_ && response == asked_;
}

bool Echo::is_of_read(std::uint8_t address, const modbus::Pdu& frame) const {
  const bool was_shown_absent = learns_ && state_ == State::absent;
  return !was_shown_absent && address == address_ && modbus::is_read(frame.bytes()) &&
         is_repetition(frame);
}

bool Echo::is_owed(const modbus::Pdu& response) const {
  return is_repetition(response) && std::ranges::find(owed_, expected_) != owed_.end();
}

bool Echo::take_owed(const modbus::Pdu& response) {
  const bool owed = is_owed(response);
  if (owed) {
    owed_.erase(std::ranges::find(owed_, expected_));
  }
  return owed;
}

void Echo::find() {
  state_ = State::present;
  shown_ = true;
  lost_ = 0;
  faults_.add(LineFault::echo_found);
}

void Echo::note_unproven() {
  if (!std::exchange(unproven_reported_, true)) {
    faults_.add(LineFault::echo_unproven);
  }
}

bool Echo::note_answered(const modbus::Pdu& response, bool came_first) {
  if (!is_repetition(response)) {
    heard_.set(address_);
  }
  if (std::exchange(echoed_, false)) {
    find();
    return false;
  }
  const bool shows_none =
      came_first && !may_answer_ && shows_anything(*asked_) && modbus::is_read(asked_->bytes());
  if (!learns_ || state_ != State::unknown || !shows_none || (shown_ && ++lost_ < kMostLost)) {
    return false;
  }
  state_ = State::absent;
  if (std::exchange(shown_, false)) {
    faults_.add(LineFault::echo_gone);
  }
  return true;
}

}  // namespace mbgate::bus
