// SPDX-License-Identifier: Apache-2.0
// Valid frames that answer no pending request, kept until they are taken.
#pragma once

#include <boost/container/static_vector.hpp>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "bus/instant.hpp"
#include "modbus/request.hpp"
#include "modbus/response.hpp"

namespace mbgate::bus {

/// A valid frame that answers no pending request.
struct UnsolicitedFrame {
  std::uint8_t address;
  modbus::Pdu pdu;
  bool is_response;      ///< it has the length of a response
  bool is_request;       ///< it can only be a request
  bool after_noise;      ///< other bytes came before it: it may look like a frame only by chance
  bool is_echo = false;  ///< found to be the echo of the last read
  Instant came;          ///< when its last byte came; what it was may be known only later
  Duration pause{0};     ///< it was cut by a pause that is longer than frame_slack

  UnsolicitedFrame(std::uint8_t from, const modbus::Pdu& heard, Instant when, bool noisy = false)
      : address(from), pdu(heard), after_noise(noisy), came(when) {
    is_response = is_whole(modbus::response_length(pdu.bytes()));
    is_request = !is_response && is_whole(modbus::request_length(pdu.bytes())) &&
                 modbus::Request::parse(pdu).has_value();
  }

 private:
  [[nodiscard]] bool is_whole(const modbus::PduLength& length) const {
    return length.kind == modbus::PduLength::Kind::known && length.bytes == pdu.bytes().size();
  }
};

/// Unsolicited frames that were not taken yet: `Most` of them; further ones are dropped.
template <std::size_t Most>
class UnsolicitedFrames {
 public:
  void add(const UnsolicitedFrame& unsolicited) {
    if (unsolicited_.size() < Most) {
      unsolicited_.push_back(unsolicited);
    }
  }
  /// Removes and returns the oldest; nothing if there is none.
  std::optional<UnsolicitedFrame> take() {
    if (unsolicited_.empty()) {
      return std::nullopt;
    }
    UnsolicitedFrame unsolicited = unsolicited_.front();
    unsolicited_.erase(unsolicited_.begin());
    return unsolicited;
  }
  void clear() { unsolicited_.clear(); }

 private:
  boost::container::static_vector<UnsolicitedFrame, Most> unsolicited_;
};

}  // namespace mbgate::bus
