// SPDX-License-Identifier: Apache-2.0
// A serial line: its drives, its adapter, and everything that goes wrong on it. One event is a
// chunk of bytes, not a byte. What overlaps on the line can be read by nobody.
#pragma once

#include <map>

#include "world/surroundings.hpp"

namespace mbgate::world {

class Line : private AnyWire {
 public:
  Line(std::size_t bus, Surroundings& around);

  /// The process opens or closes it. What is being sent, and what the adapter keeps, is lost then;
  /// the drives go on.
  void open();
  void close();
  void transmit(Id sent, Octets frame);
  /// Bytes that have not left.
  [[nodiscard]] std::size_t unsent() const;
  void begin_trouble();
  /// Nothing goes wrong any more.
  void calm_down();
  /// Nothing is heard until it is opened again at least; perhaps nothing is sent either.
  void hang();

 private:
  struct Frame {
    Id sent;
    Octets bytes;
  };
  /// What somebody says.
  struct Talk {
    Octets bytes;
    Instant begin;
    Instant end;
    std::size_t good;  ///< where the frame ends, that `came` tells of
    Came came;
    std::size_t heard = 0;
    bool damaged = false;
  };
  struct Pause {
    std::size_t at;  ///< bytes before it; 0: none
    Duration length;
  };

  void leave(const Frame& frame);
  void heard(Id sent);
  void ask(Drive& drive, Id sent);
  void respond(Drive& drive, Id sent);
  void answer(Drive& drive, Id sent, const Octets& pdu);
  [[nodiscard]] Instant begin_of(Drive& drive, const Sent& sent);
  /// Makes it something that no drive of sense says; false: it is still the answer.
  bool spoil(const Habits& habits, Octets& pdu, Octets& frame, Came& came);
  void say(Octets bytes, Instant begin, std::size_t good, const Came& came, Pause pause);
  void begin_talk(std::uint64_t number);
  void hear(std::uint64_t number, std::size_t until);
  void garble(Talk& talk);
  void hand_in(const Octets& bytes, Came came);
  [[nodiscard]] Instant arrival(Instant now);
  [[nodiscard]] Octets encode(std::uint8_t address, Bytes pdu) const;
  void make_noise();
  void ask_as_stranger();
  void stall();
  void end_stall();
  void lose_supply(std::size_t drive);
  void again(Duration every, void (Line::*what)());

  WireTimes times_;
  bool ascii_;
  std::map<std::uint64_t, Talk> talks_;
  std::uint64_t numbers_ = 0;
  std::uint64_t echo_ = 0;                      ///< of what is being sent, if the line has one
  std::map<std::size_t, Instant> talks_until_;  ///< by drive
  std::vector<Frame> kept_;                     ///< by an adapter that stalls
  std::vector<std::pair<Octets, Came>> held_;   ///< by a device server that nobody is connected to
  bool stalls_ = false;
  bool is_deaf_ = false;
  bool swallows_ = false;  ///< while it is deaf, nothing is sent either
  Id sending_ = kNone;
  Instant own_end_ = Instant::min();
  bool own_damaged_ = false;
  Instant arrived_ = Instant::min();
  Duration phase_;
};

}  // namespace mbgate::world
