// SPDX-License-Identifier: Apache-2.0
// The wire of `confusable`, with two devices on it. They answer in order, one after the other, when
// the script says so, and never later than a quarantine allows; each answer says which transmission
// it answers. Owes nothing to the product: its own CRC and its own times.
#pragma once

#include "fuzz/confusable_scene.hpp"

namespace mbgate::fuzz::confusable {

/// 19200 baud, 11 bits a character.
inline Duration time_of(std::size_t bytes) {
  constexpr std::int64_t kNanoseconds = 1'000'000'000;
  constexpr std::int64_t kBits = 11;
  constexpr std::int64_t kBaud = 19200;
  return Duration((static_cast<std::int64_t>(bytes) * kBits * kNanoseconds + kBaud - 1) / kBaud);
}

inline Pdu frame_of(std::uint8_t device, const Pdu& pdu) {
  Pdu frame{device};
  frame.insert(frame.end(), pdu.begin(), pdu.end());
  unsigned crc = 0xFFFF;
  for (const std::uint8_t byte : frame) {
    crc ^= byte;
    for (int bit = 0; bit < 8; ++bit) {
      crc = (crc & 1U) != 0 ? (crc >> 1U) ^ 0xA001U : crc >> 1U;
    }
  }
  frame.push_back(static_cast<std::uint8_t>(crc & 0xFFU));
  frame.push_back(static_cast<std::uint8_t>(crc >> 8U));
  return frame;
}

struct Transmission {
  std::uint8_t number;  ///< from 1 on
  const Request* request;
  std::size_t part;
  Instant begin;
  Instant end;
  Instant due;                       ///< the end of the response timeout
  Instant until;                     ///< and of the quarantine
  Pdu answer{};                      ///< empty: none
  std::optional<Instant> came_at{};  ///< the whole answer was handed in

  [[nodiscard]] std::uint8_t device() const { return request->device; }
  [[nodiscard]] const Pdu& pdu() const { return request->parts[part].pdu; }
  [[nodiscard]] std::uint8_t function() const { return pdu().front(); }
};

inline Pdu answer_to(const Pdu& asked, std::uint8_t number, bool refuses) {
  if (refuses) {
    return {static_cast<std::uint8_t>(asked[0] | 0x80U), number};
  }
  switch (asked[0]) {
    case 0x01:
    case 0x03:
    case 0x04:
    case 0x17: return {asked[0], 2, number, asked[2]};
    case 0x41: return {asked[0], number, asked[2]};
    default: return {asked.begin(), asked.begin() + 5};
  }
}

/// Which transmission it answers, where it says so.
inline std::optional<std::uint8_t> number_in(modbus::Bytes response) {
  if ((response[0] & 0x80U) != 0 || response[0] == 0x41) {
    return response[1];
  }
  const bool has_data = response[0] <= 4 || response[0] == 0x17;
  return has_data ? std::optional(response[2]) : std::nullopt;
}

class Wire {
 public:
  Wire(const Scene& scene, Lateness& lateness) : scene_(scene), lateness_(lateness) {}

  /// It is sent; the script says what becomes of it.
  void send(Transmission& sent, Script& script) {
    const bool lost = scene_.collides && collide(sent);
    if (scene_.hears_itself) {
      Piece echo{sent.end, frame_of(sent.device(), sent.pdu()), lateness_.next()};
      if (lost) {
        spoil(echo);
      }
      add(std::move(echo));
    }
    const std::uint8_t how = script.byte();
    const std::uint8_t when = script.byte();
    const std::uint8_t shape = script.byte();
    if (how % 8U < 7 && !lost) {
      place(sent, begin_of(sent, how % 8U, when), shape, script);
    }
  }
  /// When the driver reads next.
  [[nodiscard]] std::optional<Instant> next_reading() const {
    std::optional<Instant> next;
    for (const Piece& piece : pieces_) {
      next = bus::earlier(next, piece.at + piece.late);
    }
    return next;
  }
  /// All that lies in the descriptor. `came` gets the answers that end in it.
  Pdu read(Instant now, std::vector<Transmission*>& came) {
    Pdu bytes;
    while (!pieces_.empty() && pieces_.front().at <= now) {
      const Piece& piece = pieces_.front();
      bytes.insert(bytes.end(), piece.bytes.begin(), piece.bytes.end());
      if (piece.is_last) {
        came.push_back(piece.of);
      }
      pieces_.pop_front();
    }
    return bytes;
  }

 private:
  struct Piece {
    Instant at;  ///< reaches the descriptor
    Pdu bytes;
    Duration late;               ///< the driver reads it, if nothing makes it look before
    Transmission* of = nullptr;  ///< answers that
    bool is_last = false;
  };
  struct Answer {
    const Transmission* to;
    Instant begin;
    Instant end;
  };

  /// Where it begins if the wire is free.
  [[nodiscard]] Instant begin_of(const Transmission& sent, unsigned how, std::uint8_t when) const {
    constexpr int kSteps = 256;
    constexpr std::chrono::microseconds kStep{100};
    const Duration timeout = sent.due - sent.end;
    const Duration quarantine = sent.until - sent.due;
    switch (how) {
      case 0:
      case 1: return sent.end + scene_.timing().response_wait + kStep * when;
      case 2: return sent.end + timeout * when / kSteps;
      case 3: return sent.due + quarantine * when / kSteps;
      case 4: return sent.due + kStep * when;          // beside a repetition
      case 5: return sent.until - kStep * (when + 1);  // just inside
      default: return sent.due + Duration(std::chrono::milliseconds(when));
    }
  }
  /// Not before what the device has answered already, nor while another one sends.
  void place(Transmission& sent, Instant begin, std::uint8_t shape, Script& script) {
    constexpr std::array<std::uint8_t, 8> kGlitches{0x00, 0xFF, 0x01, 0x03, 0x06, 0x80, 0xFE, 0x10};
    constexpr std::array<Duration, 4> kPauses{Duration{0}, std::chrono::milliseconds(1),
                                              std::chrono::milliseconds(4),
                                              std::chrono::milliseconds(12)};
    sent.answer = answer_to(sent.pdu(), sent.number, (shape & 0x70U) == 0x70U);
    Pdu bytes = frame_of(sent.device(), sent.answer);
    if ((shape & 0x0CU) == 0x0CU) {
      const std::uint8_t glitch = script.byte();
      bytes.insert(bytes.begin(), 1U + glitch % 3U, kGlitches.at((glitch >> 2U) % 8U));
    }
    const std::size_t count = 1U + shape % 4U;
    const Duration pause = kPauses.at((shape >> 4U) % 4U);
    const Duration length = pause * static_cast<int>(count - 1);
    begin = std::max(begin, sent.end + scene_.timing().response_wait);
    for (const Answer& other : answers_) {
      if (other.to->device() == sent.device()) {
        begin = std::max(begin, other.end + time_of(1));
      }
    }
    begin = behind_others(begin, length);
    if (begin + length >= sent.until) {
      sent.answer.clear();  // nobody could tell any more
      return;
    }
    answers_.push_back({&sent, begin, begin + length});
    for (std::size_t at = 0; at < count; ++at) {
      const auto first = bytes.begin() + static_cast<std::ptrdiff_t>(bytes.size() * at / count);
      const auto last =
          bytes.begin() + static_cast<std::ptrdiff_t>(bytes.size() * (at + 1) / count);
      add({begin + pause * static_cast<int>(at), Pdu(first, last), lateness_.next(), &sent,
           at + 1 == count});
    }
  }
  [[nodiscard]] Instant behind_others(Instant begin, Duration length) const {
    for (bool free = false; !free;) {
      free = true;
      for (const Answer& other : answers_) {
        if (begin <= other.end && other.begin <= begin + length) {
          begin = other.end + time_of(1);
          free = false;
        }
      }
    }
    return begin;
  }
  void add(Piece piece) {
    const auto place = std::ranges::upper_bound(pieces_, piece.at, {}, &Piece::at);
    pieces_.insert(place, std::move(piece));
  }
  static void spoil(Piece& piece) {
    std::ranges::for_each(piece.bytes, [](std::uint8_t& byte) { byte ^= 0x5AU; });
    piece.of = nullptr;
    piece.is_last = false;
  }
  /// What a device sends meanwhile is destroyed, and so is what is sent: is it?
  bool collide(const Transmission& sent) {
    bool lost = false;
    for (const Answer& answer : answers_) {
      if (answer.begin > sent.end || answer.end < sent.begin) {
        continue;
      }
      lost = true;
      for (Piece& piece : pieces_) {
        if (piece.of == answer.to) {
          spoil(piece);
        }
      }
    }
    return lost;
  }

  const Scene& scene_;
  Lateness& lateness_;
  std::deque<Piece> pieces_;  // in the order in which they come
  std::vector<Answer> answers_;
};

}  // namespace mbgate::fuzz::confusable
