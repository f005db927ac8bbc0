// SPDX-License-Identifier: Apache-2.0
// The far end of a Modbus TCP bus: answers come late, in another order, in pieces, with identifiers
// or units of nobody, with wrong lengths, or break off; connections are closed when they are idle
// or after an answer.
#pragma once

#include "world/surroundings.hpp"

namespace mbgate::world {

class Server : private AnyWire {
 public:
  Server(std::size_t bus, Surroundings& around);

  void open();
  void close();
  void transmit(Id sent, Octets frame);
  void begin_trouble();
  void calm_down();

 private:
  void heard(Id sent);
  void respond(Drive& drive, Id sent);
  void say(Id sent, const Octets& pdu, bool fits, bool is_second);
  void deliver(const Octets& bytes, Came came);
  void hang_up(const char* kind);
  void watch_idle();
  void hang();
  void lose_supply(std::size_t drive);

  bool is_mute_ = false;  ///< nothing comes on this connection any more
  Instant last_byte_ = Instant::min();
};

}  // namespace mbgate::world
