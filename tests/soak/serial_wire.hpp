// SPDX-License-Identifier: Apache-2.0
// A serial line with its devices and everything that goes wrong on it. One event is a chunk of
// bytes, not a byte. What overlaps on the line is garbled for everybody.
//
// Nothing here goes beyond what the contract lets the gateway tell apart:
// - damage is what the CRC (up to 3 bits) or the LRC (1 bit) detects for certain, one kind a frame;
// - the second copy of an answer, and whatever a device babbles behind one, follows the first
//   without a silence, because a device that has answered owes nothing and a later copy cannot be
//   told from the answer to a like request;
// - glitches stand only before answers whose length a byte count or the request tells;
// - what nobody has sent makes no frame, neither by a chance CRC nor as zeros that leave the CRC
//   good of one that only silence ends, or of an echo that the settings deny (`soak/overheard`);
// - in ASCII noise has no LF: an answer that has lost its own would be whole within 1 s;
// - an answer of the wrong unit has an address that nobody uses;
// - a stranger on the line asks no device that owes the gateway an answer, and has its own answer
//   before the line was silent.
// An adapter that hands bytes over late undoes some of that: what was not silent on the line is so
// for the kernel. Where a request leaves while the adapter still has such a frame, nobody can tell,
// and the oracle counts it apart; so it does where a second copy looks like the answer that the
// device still owes to an earlier try.
#pragma once

#include <map>
#include <optional>

#include "soak/adapter.hpp"
#include "soak/overheard.hpp"
#include "soak/specification.hpp"
#include "soak/surroundings.hpp"

namespace mbgate::soak {

class SerialWire {
 public:
  SerialWire(std::size_t bus, Surroundings& around);

  /// The process has opened the line, or has it no more: what an adapter still has, and what comes
  /// meanwhile, is lost, and so is the rest of a frame that it was sending. The drives go on.
  void reset(bool is_open);
  void transmit(const Flight& flight, Bytes frame);
  /// From now on nothing goes wrong any more.
  void calm_down() {
    rates_ = FaultRates{};
    is_calm_ = true;
    end_hang();
    babbles_until_ = Instant::min();
    adapter_.calm_down();
  }
  void begin_trouble();

 private:
  using Frame = std::vector<std::uint8_t>;
  enum class Chunks : std::uint8_t { usual, fine, paused, torn };
  /// What a message begins with.
  struct Content {
    std::optional<std::uint8_t> address;  ///< of good frames, none if it has none
    std::size_t copies = 1;               ///< of them
    std::size_t excess = 0;               ///< bytes behind them
    bool fits = true;                     ///< they answer what was asked
    std::uint64_t flight = 0;             ///< that they answer; none if a stranger asked
    std::size_t lead = 0;                 ///< bytes before them
    Duration most_paused = Duration::max();
    bool is_second = false;          ///< it was said before, by the same device or another one
    std::optional<Instant> began{};  ///< the part of it that came before
    std::size_t before = 0;          ///< its bytes
  };
  /// A late answer, of which only the beginning was said.
  struct Straddling {
    std::uint64_t head;  ///< its message
    std::uint64_t flight;
    std::uint8_t address;
    std::size_t size;
    Instant began;
    Instant rests_from;
    Frame rest;
    bool meets = false;  ///< another request meanwhile
  };
  struct OwnEcho {
    std::uint64_t flight = 0;
    Frame bytes;
    std::size_t heard = 0;
    bool is_whole = true;
    bool is_spoilt = false;  ///< one byte is another
    Instant began{};
  };
  enum class Spoilt : std::uint8_t { no, unreadable, misfit };
  struct Message {
    /// How many of the frames end in so many bytes.
    [[nodiscard]] std::size_t ended(std::size_t size) const {
      return size < content.lead ? 0 : (size - content.lead) / frame;
    }
    /// Is the byte part of a good frame? What a stranger asks stands in one too.
    [[nodiscard]] bool is_of_frame(std::size_t at) const {
      return at < good_to && at >= cut_to() && (at >= content.lead || content.flight == 0);
    }
    /// Where the first frame begins that was not heard in part only, when the line was opened.
    [[nodiscard]] std::size_t cut_to() const {
      if (lost <= content.lead) {
        return lost == 0 ? 0 : content.lead;
      }
      return content.lead + (lost - content.lead + frame - 1) / frame * frame;
    }

    Frame bytes;
    Instant begin;
    Instant end;
    Duration character;
    Content content;
    std::size_t frame;    ///< their size
    std::size_t good_to;  ///< where the last of them ends, or what was hit begins
    std::size_t heard = 0;
    std::size_t lost = 0;  ///< of these, before the line was opened
    std::size_t copies_heard = 0;
    Instant frame_began{};  ///< when the first byte of the present frame will reach the kernel
    std::uint64_t frame_from = 0;  ///< the bytes that the line had brought before that
  };

  void heard(std::uint64_t number);
  void carry_out_all(const Flight& flight);
  // wire_echo.cpp
  void begin_echo(const Flight& flight, const Frame& frame);
  void spoil_echo(const Flight& flight);
  void hear_echo(std::uint64_t number, std::size_t until);
  [[nodiscard]] bool happens_to_echo(unsigned permille, const char* kind);
  [[nodiscard]] std::optional<Instant> prompt_end(const Flight& flight);
  void begin_babble();
  void babble_on(std::uint64_t epoch);
  [[nodiscard]] bool is_babbling() const;
  // wire_hang.cpp
  void begin_hang();
  void end_hang();
  [[nodiscard]] bool is_hung() const;
  [[nodiscard]] bool goes_on_hanging();

  void answer(SoakDevice& device, const Flight& flight, const modbus::Pdu& request);
  void answer_with_fault(SoakDevice& device, const Flight& flight, const modbus::Pdu& pdu,
                         Instant begin);
  /// wire_stuck.cpp: nothing more of the answer comes.
  [[nodiscard]] bool gets_stuck(const Flight& flight, const Frame& frame, Instant begin);
  // wire_slow.cpp
  [[nodiscard]] std::optional<std::uint8_t> refusal_of(const Flight& flight);
  [[nodiscard]] bool waits_its_turn(const SoakDevice& device, const Flight& flight);
  void answer_again(const SoakDevice& device, const Flight& flight, const Frame& frame,
                    Instant begin);
  [[nodiscard]] const Ways& ways_of(const SoakDevice& device) const;
  // wire_rare.cpp
  [[nodiscard]] bool happens_rarely(unsigned permille, const char* kind);
  void part(const SoakDevice& device, const Flight& flight, const modbus::Pdu& pdu);
  void lose_check(Frame& frame) const;
  [[nodiscard]] bool straddles(const Flight& flight, const Frame& whole, Instant begin);
  void begin_to_straddle(std::uint64_t flight, std::uint8_t address, const Frame& frame);
  void meet_straddling(const Flight& flight);
  void end_straddling(Instant at);
  std::size_t begin_with_other_length(Frame& frame, const Flight& flight, const modbus::Pdu& pdu);
  void answer_late(SoakDevice& device, const Flight& flight, const Frame& frame, Instant begin);
  Spoilt spoil(Frame& frame, const modbus::Pdu& pdu, std::uint8_t address);
  // wire_strangers.cpp
  void damage(Frame& frame);
  void lose_crc(std::vector<std::uint8_t>& damaged, std::size_t from) const;
  std::size_t begin_with_glitch(Frame& frame, const PduBytes& asked);
  void append_excess(Frame& frame);
  void say(Frame bytes, Instant begin, Chunks chunks, const Content& content);
  void begin_message(std::uint64_t id);
  void hear(std::uint64_t id, std::size_t until);
  void overhear(Message& message, std::size_t until);
  void overhear(Frame& bytes, bool are_stray);
  void hand_over(const Heard& heard);
  std::optional<std::uint8_t> garble(Message& message);
  [[nodiscard]] Frame encode(std::uint8_t address, const modbus::Pdu& pdu) const;
  [[nodiscard]] SoakDevice* device_at(std::uint8_t address);
  [[nodiscard]] bool is_busy() const;
  void make_noise();
  void ask_as_stranger();
  [[nodiscard]] std::vector<std::uint8_t> strange_request();
  void kill_a_device();
  void put_to_sleep(std::size_t place);
  [[nodiscard]] bool is_sleeper(const SoakDevice& device) const;
  void later(Duration every, void (SerialWire::*what)());
  [[nodiscard]] bool happens(unsigned permille, const char* kind);

  std::size_t bus_;
  Surroundings& around_;
  const gateway::BusSettings& settings_;
  FaultRates rates_;
  bus::LineSettings line_;  ///< that drives are set to
  spec::WireTimes timing_;
  Duration silence_;
  bool ascii_;
  Adapter adapter_;
  std::vector<SoakDevice*> devices_;
  std::map<std::uint8_t, Instant> talks_until_;
  std::map<std::uint8_t, Instant> works_until_;  ///< slow drives
  std::map<std::uint8_t, Instant> asked_until_;  ///< the gateway may still wait for an answer
  std::map<std::uint64_t, Message> messages_;
  std::uint64_t ids_ = 0;
  std::uint64_t epoch_ = 0;  ///< grows when drives are set to another line
  bool is_open_ = false;
  bool is_calm_ = false;       ///< slow drives are quick, and nobody answers twice
  std::uint64_t sending_ = 0;  ///< what was transmitted last, unless its rest is lost
  Instant own_end_ = Instant::min();
  std::uint8_t asked_ = 0;  ///< the address that something was transmitted to last
  Overheard overheard_;
  bool own_damaged_ = false;
  bool is_prompt_ = false;  ///< what was transmitted last is answered before it has left
  Random echo_random_;
  Random rare_random_;
  Random slow_random_;
  std::optional<Straddling> straddling_;
  std::optional<OwnEcho> echo_;  ///< of what was transmitted last
  unsigned echoes_lost_ = 0;     ///< one after the other
  bool echo_shown_ = false;      ///< one came whole that can be nothing else
  Instant babbles_until_ = Instant::min();
  Instant deaf_until_ = Instant::min();  ///< what began before is not heard
  bool swallows_ = false;                ///< while it hangs, nothing is transmitted
  bool opaque_ = false;  ///< only silence ends the answer to what was transmitted last
};

}  // namespace mbgate::soak
