// SPDX-License-Identifier: Apache-2.0
// A connection to a running mbgated, at a `place`: the path of its control socket, or
// "tcp://HOST:PORT", one of its [http] listen, where it can only be read.
#pragma once

#include <boost/asio/generic/stream_protocol.hpp>
#include <boost/system/error_code.hpp>
#include <chrono>
#include <cstddef>
#include <functional>
#include <string>

namespace mbgate::ctl {

using ControlConnection = boost::asio::generic::stream_protocol::socket;

/// How long a wish to give up goes unnoticed.
inline constexpr std::chrono::milliseconds kLook{50};

/// How long the answer is waited for.
struct Patience {
  std::chrono::steady_clock::time_point end;
  const std::function<bool()>& give_up;

  [[nodiscard]] bool is_over() const {
    return std::chrono::steady_clock::now() >= end || (give_up && give_up());
  }
};

/// Why this is no place, a sentence, or nothing.
std::string wrong_place(const std::string& place);

/// The place must not be wrong. Where the patience is over, the error is timed_out.
boost::system::error_code connect(ControlConnection& connection, const std::string& place,
                                  const Patience& patience);

/// Tries `count` places one by one until one can be reached. Each but the last gets a share of what
/// is left of the patience: one that never answers leaves time for the others.
boost::system::error_code try_in_turn(
    std::size_t count, const Patience& patience,
    const std::function<boost::system::error_code(std::size_t place, const Patience& share)>&
        attempt);

/// What HTTP calls the other end: of TCP its address, by which it always answers.
std::string host_of(const ControlConnection& connection);

/// What the operator is to do about it.
std::string explain(const std::string& place, const boost::system::error_code& error);

}  // namespace mbgate::ctl
