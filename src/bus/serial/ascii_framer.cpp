// SPDX-License-Identifier: Apache-2.0
#include "bus/serial/ascii_framer.hpp"

#include <algorithm>
#include <cctype>
#include <tuple>
#include <utility>

#include "modbus/response.hpp"

namespace mbgate::bus {
namespace {

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

void AsciiFramer::expect(const Transaction& transaction) {
  listen();
  transaction_ = &transaction;
  is_earlier_ = !buffer_.empty();
  restarts_ = 0;
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
  for (const std::uint8_t character : std::exchange(rest_, {})) {
    std::ignore = take(character, last_character_);
  }
}

void AsciiFramer::forget() {
  listen();
  discard();
}

void AsciiFramer::discard() {
  counters_.stray_bytes += buffer_.size();
  buffer_.clear();
}

Verdict AsciiFramer::add(modbus::Bytes bytes, Instant now) {
  if (now - last_character_ >= kLongestCharacterGap) {
    discard();
  }
  last_character_ = now;
  for (std::size_t at = 0; at < bytes.size(); ++at) {
    if (const Verdict verdict = take(bytes[at], now); verdict != Verdict::none) {
      const modbus::Bytes rest = bytes.subspan(at + 1);
      const std::size_t kept = std::min(rest.size(), rest_.capacity());
      rest_.assign(rest.begin(), rest.begin() + static_cast<std::ptrdiff_t>(kept));
      counters_.stray_bytes += rest.size() - kept;
      return verdict;
    }
  }
  return Verdict::none;
}

Verdict AsciiFramer::again(Instant now) {
  found_.pdu.reset();
  const modbus::AsciiBytes rest = std::exchange(rest_, {});
  return add({rest.data(), rest.size()}, now);
}

Verdict AsciiFramer::take(std::uint8_t character, Instant now) {
  ++taken_;
  if (character == modbus::kAsciiStart || buffer_.size() == buffer_.capacity()) {
    restarts_ += in_progress() ? 1U : 0U;
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
  return character == modbus::kAsciiEnd ? judge(now) : Verdict::none;
}

Verdict AsciiFramer::judge(Instant now) {
  const auto content = modbus::ascii_content({buffer_.data(), buffer_.size()});
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
  return transaction_ != nullptr && !is_earlier_ && known > 0 && buffer_.size() < longest_ &&
         restarts_ <= kMostRestarts &&
         std::equal(
             start_.begin(), start_.begin() + static_cast<std::ptrdiff_t>(known), buffer_.begin(),
             [](std::uint8_t expected, std::uint8_t seen) { return expected == folded(seen); });
}

std::optional<Instant> AsciiFramer::next_deadline() const {
  return in_progress() ? std::optional(last_character_ + kLongestCharacterGap) : std::nullopt;
}

Verdict AsciiFramer::handle_deadline(Instant now) {
  const auto deadline = next_deadline();
  if (deadline && now >= *deadline) {
    discard();
  }
  return Verdict::none;
}

}  // namespace mbgate::bus
