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
// - no zeros come behind an answer that only silence ends: they leave a good CRC good;
// - an answer of the wrong unit has an address that nobody uses;
// - in the quiet phase nobody answers within t3.5 behind an echo that the settings deny: that echo
//   is then another client's request, and what follows without a silence answers that;
// - a stranger on the line asks no device that owes the gateway an answer, and has its own answer
//   before the line was silent.
// An adapter that hands bytes over late undoes some of that: what was not silent on the line is so
// for the kernel. Where a request leaves while the adapter still has such a frame, nobody can tell,
// and the oracle counts it apart.
#pragma once

#include <map>
#include <optional>

#include "soak/adapter.hpp"
#include "soak/specification.hpp"
#include "soak/surroundings.hpp"

namespace mbgate::soak {

class SerialWire {
 public:
  SerialWire(std::size_t bus, Surroundings& around);

  /// The adapter was opened, or pulled out: what is on the line is lost.
  void reset();
  void transmit(const Flight& flight, Bytes frame);
  /// From now on nothing goes wrong any more.
  void calm_down() {
    is_calm_ = true;
    rates_ = FaultRates{};
    babbles_until_ = Instant::min();
    adapter_.calm_down();
  }
  void begin_trouble();

 private:
  using Frame = std::vector<std::uint8_t>;
  enum class Chunks : std::uint8_t { usual, fine, paused };
  /// What a message begins with.
  struct Content {
    std::optional<std::uint8_t> address;  ///< of good frames, none if it has none
    std::size_t copies = 1;               ///< of them
    std::size_t excess = 0;               ///< bytes behind them
    bool fits = true;                     ///< they answer what was asked
    std::uint64_t flight = 0;             ///< that they answer; none if a stranger asked
    std::size_t lead = 0;                 ///< bytes before them
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

    Frame bytes;
    Instant begin;
    Instant end;
    Duration character;
    Content content;
    std::size_t frame;  ///< their size
    std::size_t heard = 0;
    std::size_t copies_heard = 0;
    Instant frame_began{};  ///< when the first byte of the present frame will reach the kernel
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

  void answer(SoakDevice& device, const Flight& flight, const modbus::Pdu& request);
  void answer_with_fault(SoakDevice& device, const Flight& flight, const modbus::Pdu& pdu,
                         Instant begin);
  void answer_late(SoakDevice& device, const Flight& flight, const Frame& frame, Instant begin);
  Spoilt spoil(Frame& frame, const modbus::Pdu& pdu, std::uint8_t address);
  void damage(Frame& frame);
  void lose_crc(std::vector<std::uint8_t>& damaged, std::size_t from) const;
  std::size_t begin_with_glitch(Frame& frame);
  void append_excess(Frame& frame);
  void say(Frame bytes, Instant begin, Chunks chunks, const Content& content);
  void begin_message(std::uint64_t id);
  void hear(std::uint64_t id, std::size_t until);
  void hand_over(const Heard& heard);
  std::optional<std::uint8_t> garble(Message& message);
  [[nodiscard]] Frame encode(std::uint8_t address, const modbus::Pdu& pdu) const;
  [[nodiscard]] SoakDevice* device_at(std::uint8_t address);
  [[nodiscard]] bool is_busy() const;
  void make_noise();
  void ask_as_stranger();
  void kill_a_device();
  void later(Duration every, void (SerialWire::*what)());
  [[nodiscard]] bool happens(unsigned permille, const char* kind);

  std::size_t bus_;
  Surroundings& around_;
  const gateway::BusSettings& settings_;
  FaultRates rates_;
  spec::WireTimes timing_;
  Duration silence_;
  bool ascii_;
  Adapter adapter_;
  std::vector<SoakDevice*> devices_;
  std::map<std::uint8_t, Instant> talks_until_;
  std::map<std::uint8_t, Instant> asked_until_;  ///< the gateway may still wait for an answer
  std::map<std::uint64_t, Message> messages_;
  std::uint64_t ids_ = 0;
  std::uint64_t epoch_ = 0;  ///< grows when the adapter is pulled out
  Instant own_end_ = Instant::min();
  bool own_damaged_ = false;
  bool is_prompt_ = false;  ///< what was transmitted last is answered before it has left
  Random echo_random_;
  std::optional<OwnEcho> echo_;  ///< of what was transmitted last
  Instant babbles_until_ = Instant::min();
  bool is_calm_ = false;
  bool opaque_ = false;  ///< only silence ends the answer to what was transmitted last
};

}  // namespace mbgate::soak
