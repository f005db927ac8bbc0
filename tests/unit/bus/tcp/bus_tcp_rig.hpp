// SPDX-License-Identifier: Apache-2.0
// A bus that is a connection to a Modbus TCP server.
#pragma once

#include "unit/bus/bus_rig.hpp"

namespace mbgate::test {

class BusTcp : public Bus {
 protected:
  static bus::BusSettings tcp(std::size_t outstanding = 1) {
    auto tcp = settings();
    tcp.line.framing = bus::Framing::tcp;
    tcp.line.remote = bus::Endpoint{"drive", 502};
    tcp.outstanding = outstanding;
    tcp.listen_first.reset();
    return tcp;
  }
  /// An answer with the transaction identifier of the given frame.
  void answer(std::size_t frame, std::string_view unit_and_pdu) {
    const auto body = unhex(unit_and_pdu);
    line(frames_.at(frame).substr(0, 5) + " 00 00 00 " +
         hex(std::vector{static_cast<std::uint8_t>(body.size())}) + hex(body));
  }
  /// The far end closes the connection.
  void close() {
    bus_->handle_lost(now_, bus::Loss::closed);
    drain();
  }
  void reopen() {
    bus_->handle_opened(now_);
    drain();
  }
  /// The units of the frames so far.
  [[nodiscard]] std::vector<int> units() const {
    std::vector<int> units;
    for (const std::string& frame : frames_) {
      units.push_back(unhex(frame)[6]);
    }
    return units;
  }
};

}  // namespace mbgate::test
