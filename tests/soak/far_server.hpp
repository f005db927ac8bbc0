// SPDX-License-Identifier: Apache-2.0
// The far end of a downstream TCP bus: answers come late, in another order, in pieces of any size,
// with identifiers that nobody used or another unit; connections break, are closed when they are
// idle, after an answer or at once, or swallow everything. Some answers are not what was asked for.
// Nothing is damaged on the way.
#pragma once

#include "soak/specification.hpp"
#include "soak/surroundings.hpp"

namespace mbgate::soak {

class FarServer {
 public:
  FarServer(std::size_t bus, Surroundings& around);

  void reset(bool is_open);
  void begin_connection();
  void transmit(const Flight& flight);
  void calm_down() {
    rates_ = FaultRates{};
    swallows_ = false;
    in_bout_ = 0;
  }
  void begin_trouble();

 private:
  struct Answer {
    std::uint64_t number;
    std::uint16_t identifier;
    std::uint8_t unit;
    std::vector<std::uint8_t> pdu;
    bool fits = true;  ///< it is what was asked for
  };
  void heard(std::uint64_t number);
  [[nodiscard]] bool drops();
  void part(const Flight& flight, const modbus::Pdu& pdu);
  void say(const Answer& answer);
  void break_framing();
  void flush(std::size_t bytes);
  void note_answer(std::uint64_t number);
  [[nodiscard]] bool breaks_off();
  [[nodiscard]] bool may_close() const { return answered_ || !unsure_; }
  void close(const char* kind);
  void close_soon(const char* kind);
  void watch_idle();
  void kill_a_device();
  [[nodiscard]] bool happens(unsigned permille, const char* kind);

  std::size_t bus_;
  Surroundings& around_;
  FaultRates rates_;
  Random break_random_;
  std::vector<SoakDevice*> devices_;
  std::vector<std::uint8_t> stream_;
  std::deque<std::pair<std::size_t, std::uint64_t>> ends_;  ///< of answers in the stream
  std::uint64_t epoch_ = 0;
  bool swallows_ = false;
  unsigned in_bout_ = 0;   ///< requests, since it was well
  bool answered_ = false;  ///< in time, on this connection
  bool unsure_ = false;    ///< late: the gateway may not remember the request
  Instant last_byte_;      ///< in either direction
};

}  // namespace mbgate::soak
