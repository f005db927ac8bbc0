// SPDX-License-Identifier: Apache-2.0
#include "bus/tcp/tcp_discipline.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "base/assert.hpp"
#include "modbus/response.hpp"

namespace mbgate::bus {
namespace {

constexpr std::size_t kProtocolFieldEnd = 4;
constexpr std::size_t kLengthField = 4;
constexpr std::size_t kExceptionLength = 3;  // unit identifier, function code, exception code

// As far as it has come, is this the beginning of an answer with the identifier?
bool begins_with(modbus::Bytes stream, std::uint16_t identifier) {
  std::array<std::uint8_t, kProtocolFieldEnd> front{};
  modbus::store_be16(front, 0, identifier);
  return std::ranges::equal(stream.first(std::min(stream.size(), front.size())),
                            modbus::Bytes(front).first(std::min(stream.size(), front.size())));
}

}  // namespace

void TcpDiscipline::open(Instant now, LineKind /*kind*/, Instant listen_until) {
  listening_until_ = settings_.check_transaction ? Instant::min() : listen_until;
  quiet_since_ = now;
  ready_first_at_ = now + settings_.connect_delay;
}

void TcpDiscipline::limit_wait(const Transaction& transaction, Duration longest) {
  const auto flight = std::ranges::find(flights_, &transaction, &Flight::transaction);
  flight->response_deadline = std::min(flight->response_deadline, flight->sent + longest);
}

FrameBytes TcpDiscipline::begin(Transaction& transaction, const drive::DeviceTiming& timing,
                                OwedAnswers owed, Instant now) {
  MBGATE_ASSERT(!transaction.is_broadcast(), "no broadcast goes over a connection");
  const std::uint16_t identifier = new_identifier();
  const Instant due = now + timing.response_timeout + timing.response_wait;
  flights_.push_back({identifier, &transaction, now, due, due});
  asked_.push_back({identifier, transaction.address, transaction.unit});
  if (asked_.size() > kMostAsked) {
    asked_.pop_front();
  }
  owed_ = std::move(owed);
  quiet_since_ = now;
  const modbus::MbapBytes adu =
      modbus::encode({{identifier, transaction.unit}, transaction.request.pdu()});
  return {adu.begin(), adu.end()};
}

void TcpDiscipline::abort() {
  flights_.clear();
  owed_.clear();
  stream_.clear();
  padding_ = 0;
  ends_ = {};
  asked_.clear();
  unsolicited_.clear();
  fault_.reset();
  use_.forget_unanswered();
}

std::uint16_t TcpDiscipline::new_identifier() {
  do {
    ++last_identifier_;
  } while (std::ranges::count(flights_, last_identifier_, &Flight::identifier) > 0);
  std::erase_if(asked_, [this](const Sent& it) { return it.identifier == last_identifier_; });
  return last_identifier_;
}

void TcpDiscipline::handle_bytes(modbus::Bytes bytes, Instant now) {
  quiet_since_ = now;
  use_.forget_unanswered();
  if (fault_) {
    return;
  }
  stream_.insert(stream_.end(), bytes.begin(), bytes.end());
  while (take_answer(now)) {
  }
}

bool TcpDiscipline::take_answer(Instant now) {
  skip_padding();
  const modbus::MbapScan scan = modbus::scan_mbap_answer(stream_);
  // A server speaks Modbus and nothing else: another protocol means that this is no header.
  const bool is_foreign = stream_.size() >= kProtocolFieldEnd && modbus::load_be16(stream_, 2) != 0;
  if (is_foreign || std::holds_alternative<modbus::MbapLost>(scan)) {
    counters_.stray_bytes += stream_.size();
    stream_.clear();
    fault_ = LineFault::framing_lost;
    return false;
  }
  const auto* frame = std::get_if<modbus::MbapFrame>(&scan);
  if (frame == nullptr) {
    return false;
  }
  match(frame->adu, now);
  if (const std::size_t length = modbus::load_be16(stream_, kLengthField);
      frame->adu.pdu.is_exception() && length > kExceptionLength) {
    padding_ = std::min(length, modbus::kMaxPduSize + 1) - kExceptionLength;
  }
  stream_.erase(stream_.begin(), stream_.begin() + static_cast<std::ptrdiff_t>(frame->size));
  return true;
}

void TcpDiscipline::skip_padding() {
  const auto begins = [this](std::uint16_t identifier) { return begins_with(stream_, identifier); };
  const auto may_be_answer = [&] {
    return !settings_.check_transaction || std::ranges::any_of(asked_, begins, &Sent::identifier);
  };
  while (padding_ > 0 && !stream_.empty() && !may_be_answer()) {
    stream_.erase(stream_.begin());
    --padding_;
    ++counters_.stray_bytes;
  }
  padding_ = stream_.size() < kProtocolFieldEnd ? padding_ : 0;
}

void TcpDiscipline::match(const modbus::MbapAdu& answer, Instant now) {
  const auto is_from = [&](std::uint16_t identifier, std::uint8_t unit) {
    return (!settings_.check_unit || answer.header.unit == unit) &&
           (!settings_.check_transaction || answer.header.transaction == identifier);
  };
  const auto flight = std::ranges::find_if(
      flights_, [&](const Flight& it) { return is_from(it.identifier, it.transaction->unit); });
  if (flight == flights_.end()) {
    // Without identifiers it may belong to any of those that its unit sent.
    ++counters_.unsolicited_frames;
    const auto asked = std::ranges::find_if(
        asked_, [&](const Sent& it) { return is_from(it.identifier, it.unit); });
    if (asked != asked_.end()) {
      use_.note_answer(now);
      unsolicited_.add({asked->address, answer.pdu, now});
      asked_.erase(asked);
    }
    return;
  }
  Transaction& transaction = *flight->transaction;
  const auto first = first_fit(owed_, answer.pdu);
  if (first != owed_.end() && !first->is_own_answer(answer.pdu)) {
    owed_.erase(first);
    use_.note_answer(now);
    ++counters_.unsolicited_frames;
    unsolicited_.add({transaction.address, answer.pdu, now});
    return;
  }
  const auto fit = modbus::check_response(transaction.request, answer.pdu.bytes());
  if (!is_fitting(fit)) {
    ++counters_.unsolicited_frames;
    if (!settings_.check_transaction) {
      unsolicited_.add({transaction.address, answer.pdu, now});
    }
    if (!settings_.check_transaction || fit == modbus::ResponseFit::wrong_function) {
      return;
    }
  }
  use_.note_answer(now);
  transaction.response = answer.pdu;
  ends_.push(LineEnd{is_fitting(fit) ? LineEnd::How::response : LineEnd::How::misfit, &transaction,
                     flight->due, now - flight->sent});
  if (settings_.check_transaction) {
    std::erase_if(asked_, [&](const Sent& it) { return it.identifier == flight->identifier; });
  }
  flights_.erase(flight);
}

void TcpDiscipline::handle_deadline(Instant now) {
  bool is_timeout = false;
  for (const Flight& flight : flights_) {
    if (now >= flight.response_deadline) {
      is_timeout = is_timeout || now >= flight.due;
      if (!flight.transaction->may_stay_silent()) {
        use_.note_unanswered(flight.sent);
      }
      ends_.push(LineEnd{LineEnd::How::no_response, flight.transaction, flight.due});
    }
  }
  std::erase_if(flights_, [now](const Flight& flight) { return now >= flight.response_deadline; });
  // What belongs to a request that is still waited for has its time.
  const bool is_awaited =
      stream_.size() > 1 &&
      std::ranges::count(flights_, modbus::load_be16(stream_, 0), &Flight::identifier) > 0;
  const auto rest_by = stray_part_until();
  if ((is_timeout && !stream_.empty() && !is_awaited) || (rest_by && now >= *rest_by)) {
    counters_.stray_bytes += stream_.size();
    if (flights_.empty()) {
      stream_.clear();
    }
    fault_ = LineFault::answer_cut_off;
  } else if (const auto at = use_.replace_at(settings_.replace_after); at && now >= *at) {
    fault_ = LineFault::unanswered;
  }
}

std::optional<Instant> TcpDiscipline::next_deadline() const {
  std::optional<Instant> deadline =
      earlier(stray_part_until(), use_.replace_at(settings_.replace_after));
  for (const Flight& flight : flights_) {
    deadline = earlier(deadline, flight.response_deadline);
  }
  return deadline;
}

}  // namespace mbgate::bus
