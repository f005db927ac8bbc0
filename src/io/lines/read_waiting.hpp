// SPDX-License-Identifier: Apache-2.0
// Reads what is waiting in a line's descriptor, and nothing that arrives meanwhile: a peer that
// never stops sending must not block the io thread.
#pragma once

#include <algorithm>
#include <boost/asio/error.hpp>
#include <boost/system/error_code.hpp>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <span>

#include "io/unique_fd.hpp"
#include "modbus/bytes.hpp"
#include "modbus/rtu.hpp"

namespace mbgate::io {

/// So much of a line is read at once: a framer has room for that behind a frame that has begun.
inline constexpr std::size_t kLineReadSize = 2 * modbus::kMaxRtuSize;

/// Reads at most `left` bytes, in pieces that fit `buffer`. `read` gets the buffer and does what
/// ::read() does. `hand_over` gets the bytes that came, and returns whether the line is still the
/// same. Returns why the line is dead: an errno, or eof; no error otherwise.
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
