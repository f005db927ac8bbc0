// SPDX-License-Identifier: Apache-2.0
// Reading what lies in the descriptor of a line, and nothing that comes meanwhile: somebody who
// never stops sending must not keep the io thread.
#pragma once

#include <algorithm>
#include <boost/asio/error.hpp>
#include <boost/system/error_code.hpp>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <span>

#include "modbus/bytes.hpp"

namespace mbgate::io {

/// Of a call that failed with this errno: it is no failure of the descriptor, and can be made
/// again.
inline bool would_block(int error) { return error == EAGAIN || error == EINTR; }

/// At most `left` bytes, in pieces that fit `buffer`. `read` is given room and does what ::read()
/// does; `hand_over` is given what came, and says whether the line is still the same. Why the line
/// is dead: an errno, or eof; no error otherwise.
template <class Read, class HandOver>
[[nodiscard]] boost::system::error_code read_waiting(std::span<std::uint8_t> buffer,
                                                     std::size_t left, Read read,
                                                     HandOver hand_over) {
  while (left > 0) {
    const auto count = read(buffer.first(std::min(left, buffer.size())));
    if (count == 0) {
      return boost::asio::error::make_error_code(boost::asio::error::eof);
    }
    if (count < 0) {
      return would_block(errno)
                 ? boost::system::error_code()
                 : boost::system::error_code(errno, boost::system::system_category());
    }
    const auto bytes = static_cast<std::size_t>(count);
    left -= bytes;
    if (!hand_over(modbus::Bytes(buffer).first(bytes))) {
      break;
    }
  }
  return {};
}

}  // namespace mbgate::io
