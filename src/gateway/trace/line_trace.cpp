// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <chrono>
#include <functional>

#include "gateway/trace/trace_book.hpp"
#include "modbus/frames.hpp"
#include "modbus/mbap.hpp"

namespace mbgate::gateway {
namespace {

/// Bytes that nobody had asked for and that come so close behind each other are told together:
/// longer than what an adapter keeps.
constexpr Duration kPause = std::chrono::milliseconds(50);
/// A line that is never silent is told of all the same.
constexpr Duration kLongestUnasked = std::chrono::seconds(1);

void keep(WireTrace& wire, modbus::Bytes bytes, Instant now) {
  std::size_t kept = 0;
  for (const HeardBytes& part : wire.heard) {
    kept += part.bytes.size();
  }
  const modbus::Bytes taken = bytes.first(std::min(LineTrace::kMostHeard - kept, bytes.size()));
  wire.not_kept += bytes.size() - taken.size();
  if (!taken.empty()) {
    wire.heard.push_back({now, {taken.begin(), taken.end()}});
  }
}

WireTrace::Outcome outcome_of(const bus::TransmissionOver& over) {
  switch (over.how) {
    case bus::LineEnd::How::response: return WireTrace::Outcome::answered;
    case bus::LineEnd::How::sent: return WireTrace::Outcome::sent;
    case bus::LineEnd::How::no_response:
      return over.may_stay_silent ? WireTrace::Outcome::sent : WireTrace::Outcome::no_response;
    case bus::LineEnd::How::misfit:
    case bus::LineEnd::How::damaged: return WireTrace::Outcome::damaged;
  }
  return WireTrace::Outcome::cut;
}

/// The address in bytes that nobody had asked for, as far as they are a frame.
std::uint8_t address_in(modbus::Bytes bytes, bus::Framing framing) {
  constexpr std::size_t kUnit = 6;
  switch (framing) {
    case bus::Framing::rtu: return bytes.front();
    case bus::Framing::ascii: {
      const auto frame = modbus::decode_ascii(bytes);
      return frame ? frame->address : std::uint8_t{0};
    }
    case bus::Framing::tcp: return bytes.size() > kUnit ? bytes[kUnit] : std::uint8_t{0};
  }
  return 0;
}

/// What is left of the bytes when they go on with the echo; this is then shorter.
modbus::Bytes without_echo(modbus::Bytes bytes, ByteString& echo) {
  const auto [of_bytes, of_echo] = std::ranges::mismatch(bytes, echo);
  const bool goes_on = of_bytes == bytes.end() || of_echo == echo.end();
  const auto same = static_cast<std::size_t>(of_bytes - bytes.begin());
  echo = goes_on ? ByteString(of_echo, echo.end()) : ByteString();
  return goes_on ? bytes.subspan(same) : bytes;
}

/// By the identifiers that they begin with.
bool is_transaction_of(modbus::Bytes adu, const WireTrace& wire) {
  constexpr std::size_t kIdentifier = 2;
  return adu.size() >= kIdentifier && wire.frame.size() >= kIdentifier &&
         std::ranges::equal(adu.first(kIdentifier), modbus::Bytes(wire.frame).first(kIdentifier));
}

}  // namespace

template <typename IsCut>
void LineTrace::cut(IsCut is_cut, Instant now) {
  const auto all = std::ranges::stable_partition(in_flight_, std::not_fn(is_cut));
  for (Told& it : all) {
    it.wire.outcome = WireTrace::Outcome::cut;
    it.wire.ended_at = now;
    reported_.push_back(std::move(it));
  }
  in_flight_.erase(all.begin(), all.end());
}

void LineTrace::opened(const WireTrace& blank, Instant now) {
  if (!partial_.empty()) {
    hear_adu(std::exchange(partial_, {}), blank, now);
  }
  cut([](const Told&) { return true; }, now);
  end_unasked();
  from_before_ = 0;
  echo_.clear();
}

// A transmission that has no end by now was cut: a job has one at a time, and so has a serial line.
void LineTrace::began(const bus::TransmissionBegan& began, WireTrace wire) {
  end_unasked();
  echo_.clear();
  const bool is_serial = wire.framing != bus::Framing::tcp;
  from_before_ = is_serial ? 0 : from_before_;
  cut([&](const Told& it) { return is_serial || it.title.job == began.title.job; }, wire.sent_at);
  wire.tries = began.tries;
  wire.silent_since = began.silent_since;
  wire.left_at = began.leaves_at;
  wire.shared_by = began.title.requests.size();
  in_flight_.push_back({began.title, std::move(wire)});
}

void LineTrace::transmitted(modbus::Bytes frame) {
  if (!in_flight_.empty()) {
    in_flight_.back().wire.frame.assign(frame.begin(), frame.end());
  }
}

void LineTrace::heard(modbus::Bytes bytes, const WireTrace& blank, Instant now) {
  if (blank.framing == bus::Framing::tcp) {
    hear_adus(bytes, blank, now);
  } else if (in_flight_.empty()) {
    hear_unasked(without_echo(bytes, echo_), blank, now);
  } else {
    keep(in_flight_.front().wire, bytes, now);
  }
}

// A connection may carry several at a time: what belongs together is told by the identifier.
void LineTrace::hear_adus(modbus::Bytes bytes, const WireTrace& blank, Instant now) {
  ByteString all = std::exchange(partial_, {});
  all.insert(all.end(), bytes.begin(), bytes.end());
  modbus::Bytes rest = all;
  while (!rest.empty()) {
    const modbus::MbapScan scan = modbus::scan_mbap_answer(rest);
    std::size_t size = rest.size();
    if (std::holds_alternative<modbus::MbapIncomplete>(scan)) {
      break;
    }
    if (const auto* frame = std::get_if<modbus::MbapFrame>(&scan)) {
      size = frame->size;
    } else if (const auto* foreign = std::get_if<modbus::MbapForeign>(&scan)) {
      size = std::min(foreign->size, rest.size());
    }
    hear_adu(rest.first(size), blank, now);
    rest = rest.subspan(size);
  }
  partial_.assign(rest.begin(), rest.end());
}

void LineTrace::hear_adu(modbus::Bytes adu, const WireTrace& blank, Instant now) {
  const auto asked = std::ranges::find_if(
      in_flight_, [&](const Told& it) { return is_transaction_of(adu, it.wire); });
  if (asked != in_flight_.end()) {
    keep(asked->wire, adu, now);
  } else {
    end_unasked();
    hear_unasked(adu, blank, now);
  }
}

void LineTrace::hear_unasked(modbus::Bytes bytes, const WireTrace& blank, Instant now) {
  if (bytes.empty() || from_before_ > 0) {
    return;
  }
  rest(now);
  if (!unasked_) {
    unasked_ = blank;
    unasked_->device.clear();
    unasked_->address = address_in(bytes, blank.framing);
    unasked_->outcome = WireTrace::Outcome::unasked;
    unasked_->sent_at = now;
  }
  keep(*unasked_, bytes, now);
  unasked_->ended_at = now;
}

void LineTrace::over(const bus::TransmissionOver& over, Instant now) {
  const auto it = std::ranges::find_if(
      in_flight_, [&](const Told& flight) { return flight.title.job == over.title.job; });
  if (it == in_flight_.end()) {
    from_before_ -= from_before_ > 0 ? 1 : 0;  // it began before anybody read along
    return;
  }
  WireTrace wire = std::move(it->wire);
  in_flight_.erase(it);
  wire.outcome = outcome_of(over);
  wire.ended_at = now;
  wire.shared_by = over.title.requests.size();
  wire.held_until = over.held_until;
  if (over.response) {
    const modbus::Bytes pdu = over.response->bytes();
    wire.response = ByteString(pdu.begin(), pdu.end());
  } else if (is_transaction_of(partial_, wire)) {
    keep(wire, std::exchange(partial_, {}), now);  // it was announced longer than it is
  }
  if (over.how == bus::LineEnd::How::sent && wire.heard.empty()) {
    echo_ = wire.frame;
  }
  reported_.push_back({over.title, std::move(wire)});
}

void LineTrace::answered(std::uint32_t request, Instant now) {
  cut([&](const Told& it) { return std::ranges::count(it.title.requests, request) > 0; }, now);
}

void LineTrace::rest(Instant now) {
  if (unasked_ && (now - unasked_->ended_at >= kPause ||
                   now - unasked_->sent_at >= kLongestUnasked || unasked_->not_kept > 0)) {
    end_unasked();
  }
}

void LineTrace::end_unasked() {
  if (unasked_) {
    reported_.push_back({{}, *std::exchange(unasked_, std::nullopt)});
  }
}

}  // namespace mbgate::gateway
