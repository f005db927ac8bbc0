// SPDX-License-Identifier: Apache-2.0
// Good frames that answer nothing that was asked, until somebody asks for them.
#pragma once

#include <boost/container/static_vector.hpp>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "bus/instant.hpp"
#include "modbus/request_length.hpp"
#include "modbus/response.hpp"

namespace mbgate::bus {

/// A good frame that answers nothing that was asked.
struct UnsolicitedFrame {
  std::uint8_t address;
  modbus::Pdu pdu;
  bool is_response;      ///< it has the length of one
  bool is_request;       ///< it can be nothing else
  bool after_noise;      ///< other bytes stood before it: it may be a frame by chance only
  bool is_echo = false;  ///< the line says so: of the read that was asked last
  Instant came;          ///< its last byte; what it was may be known only later

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

/// Those that were seen and not told yet: `Most`, and no more.
template <std::size_t Most>
class UnsolicitedFrames {
 public:
  void add(const UnsolicitedFrame& unsolicited) {
    if (unsolicited_.size() < Most) {
      unsolicited_.push_back(unsolicited);
    }
  }
  /// The oldest, each once.
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
