// SPDX-License-Identifier: Apache-2.0
#include "bus/serial/ascii_framer.hpp"

#include <algorithm>
#include <cctype>
#include <tuple>
#include <utility>

#include "modbus/response.hpp"

namespace mbgate::bus {
namespace {

constexpr std::uint8_t kCarriageReturn = '\r';

// Capital and small hexadecimal digits mean the same.
std::uint8_t folded(std::uint8_t character) {
  constexpr std::uint8_t kSmallLetter = 0x20;
  return character >= 'a' && character <= 'f' ? static_cast<std::uint8_t>(character - kSmallLetter)
                                              : character;
}

// Serial Line V1.02, 2.5.2.1: hexadecimal digits between the colon and CR LF.
bool may_stand_in_frame(std::uint8_t character) {
  return std::isxdigit(character) != 0 || character == modbus::kAsciiStart || character == '\r' ||
         character == modbus::kAsciiEnd;
}

}  // namespace

void AsciiFramer::expect(const Transaction& transaction, Instant sent) {
  listen();
  transaction_ = &transaction;
  is_paced_ = sent != Instant::min();
  hurried_.reset();
  is_earlier_ = !buffer_.empty();
  taken_ = 0;
  found_.pdu.reset();
  const auto frame = modbus::encode_ascii(transaction.address, transaction.request.pdu());
  std::copy_n(frame.begin(), start_.size(), start_.begin());
  const modbus::PduLength length = modbus::expected_response_length(transaction.request);
  longest_ = length.kind == modbus::PduLength::Kind::known
                 ? modbus::kAsciiFraming + 2 * (length.bytes + 2)
                 : modbus::kMaxAsciiSize;
}

void AsciiFramer::listen() {
  transaction_ = nullptr;
  if (is_whole_) {
    std::ignore = judge(last_character_);
  }
  const modbus::AsciiBytes rest = std::exchange(rest_, {});
  std::ignore = add({rest.data(), rest.size()}, last_character_);
}

void AsciiFramer::forget() {
  listen();
  discard();
}

void AsciiFramer::discard() {
  counters_.stray_bytes += buffer_.size();
  buffer_.clear();
  is_whole_ = false;
}

Verdict AsciiFramer::add(modbus::Bytes bytes, Instant now) {
  if (now - last_character_ >= kLongestCharacterGap && !is_whole_) {
    discard();
  }
  last_character_ = now;
  for (std::size_t at = 0; at < bytes.size(); ++at) {
    if (is_whole_ && bytes[at] != modbus::kAsciiEnd) {
      if (const Verdict verdict = judge(now); verdict != Verdict::none) {
        return keep_rest(verdict, bytes.subspan(at));
      }
    }
    if (const Verdict verdict = take(bytes[at], now); verdict != Verdict::none) {
      return keep_rest(verdict, bytes.subspan(at + 1));
    }
  }
  return Verdict::none;
}

Verdict AsciiFramer::keep_rest(Verdict verdict, modbus::Bytes rest) {
  const std::size_t kept = std::min(rest.size(), rest_.capacity());
  rest_.assign(rest.begin(), rest.begin() + static_cast<std::ptrdiff_t>(kept));
  counters_.stray_bytes += rest.size() - kept;
  return verdict;
}

Verdict AsciiFramer::again(Instant now) {
  found_.pdu.reset();
  const modbus::AsciiBytes rest = std::exchange(rest_, {});
  return add({rest.data(), rest.size()}, now);
}

Verdict AsciiFramer::take(std::uint8_t character, Instant now) {
  ++taken_;
  if (character == modbus::kAsciiStart || buffer_.size() == buffer_.capacity()) {
    discard();
  }
  if (!may_stand_in_frame(character)) {
    discard();
  }
  if (buffer_.empty() && character != modbus::kAsciiStart) {
    ++counters_.stray_bytes;
    return Verdict::none;
  }
  if (buffer_.empty()) {
    is_earlier_ = false;
    began_ = now;
    began_first_ = taken_ == 1;
  }
  buffer_.push_back(character);
  if (is_paced_) {
    began_ = std::min(began_, now - timing_.least_duration_of(buffer_.size()));
  }
  if (character == kCarriageReturn) {
    is_whole_ = ends_well();
  }
  if (character == modbus::kAsciiEnd) {
    return judge(now);
  }
  return Verdict::none;
}

// What the characters stand for that have come, if CR LF or one of them alone ends them.
std::optional<modbus::AsciiContent> AsciiFramer::content() const {
  const auto is_end = [](std::uint8_t it) {
    return it == kCarriageReturn || it == modbus::kAsciiEnd;
  };
  const auto end = std::ranges::find_if(buffer_, is_end);
  modbus::AsciiBytes whole(buffer_.begin(), end);
  if (buffer_.end() - end > 2 || whole.size() + 2 > whole.capacity()) {
    return std::nullopt;
  }
  whole.push_back(kCarriageReturn);
  whole.push_back(modbus::kAsciiEnd);
  return modbus::ascii_content({whole.data(), whole.size()});
}

bool AsciiFramer::ends_well() const {
  const auto whole = content();
  return whole && modbus::has_good_lrc({whole->data(), whole->size()});
}

Verdict AsciiFramer::judge(Instant now) {
  is_whole_ = false;
  const bool is_exact = modbus::ascii_content({buffer_.data(), buffer_.size()}).has_value();
  const auto content = is_exact || ends_well() ? this->content() : std::nullopt;
  if (!content) {
    discard();
    return Verdict::none;
  }
  const modbus::Bytes bytes(content->data(), content->size());
  const modbus::Bytes pdu = bytes.subspan(1, bytes.size() - 2);
  using modbus::ResponseFit;
  const bool may_answer = transaction_ != nullptr && !is_earlier_;
  const ResponseFit fit = may_answer && bytes[0] == transaction_->address
                              ? modbus::check_response(transaction_->request, pdu)
                              : ResponseFit::wrong_function;
  if (!modbus::has_good_lrc(bytes)) {
    discard();
    const bool stranger = fit == ResponseFit::wrong_function || fit == ResponseFit::wrong_length;
    return stranger ? Verdict::none : Verdict::damaged;
  }
  buffer_.clear();
  if (is_fitting(fit)) {
    found_ = {modbus::Pdu::from(pdu), began_, began_first_};
    return Verdict::response;
  }
  ++counters_.unsolicited_frames;
  unsolicited_.add({bytes[0], *modbus::Pdu::from(pdu), now});
  return Verdict::none;
}

bool AsciiFramer::in_progress() const {
  const std::size_t known = std::min(buffer_.size(), start_.size());
  const bool is_short = buffer_.size() < longest_ || is_whole_;
  return transaction_ != nullptr && !is_earlier_ && known > 0 && is_short &&
         std::equal(
             start_.begin(), start_.begin() + static_cast<std::ptrdiff_t>(known), buffer_.begin(),
             [](std::uint8_t expected, std::uint8_t seen) { return expected == folded(seen); });
}

std::optional<Instant> AsciiFramer::next_deadline() const {
  if (is_whole_) {
    return last_character_ + slack_;
  }
  if (!in_progress()) {
    return std::nullopt;
  }
  const Instant on_wire = began_ + timing_.duration_of(longest_);
  Instant deadline = std::min(last_character_, on_wire) + kLongestCharacterGap;
  if (hurried_) {
    deadline = std::min(deadline, std::max(*hurried_, on_wire + slack_));
  }
  return deadline;
}

Verdict AsciiFramer::handle_deadline(Instant now) {
  const auto deadline = next_deadline();
  if (!deadline || now < *deadline) {
    return Verdict::none;
  }
  if (is_whole_) {
    return judge(now);
  }
  discard();
  return Verdict::none;
}

}  // namespace mbgate::bus
