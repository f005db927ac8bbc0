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

#include "base/text.hpp"
#include "modbus/result.hpp"
#include "sys/unique_fd.hpp"

namespace mbgate::ctl {

using ControlConnection = boost::asio::generic::stream_protocol::socket;

/// How long a wish to give up goes unnoticed.
inline constexpr std::chrono::milliseconds kLook{50};

/// Until when something is waited for, unless `give_up` says so earlier.
struct WaitLimit {
  std::chrono::steady_clock::time_point end;
  const std::function<bool()>& give_up;

  [[nodiscard]] bool is_over() const {
    return std::chrono::steady_clock::now() >= end || (give_up && give_up());
  }
};

/// Why this is no place, a sentence, or nothing.
std::string wrong_place(const std::string& place);

/// The place must not be wrong. Where the time is over, the error is timed_out.
boost::system::error_code connect(ControlConnection& connection, const std::string& place,
                                  const WaitLimit& limit);

/// A socket, which does not block, that is connected to the server; or why not.
Result<sys::UniqueFd, std::string> connect_tcp(const HostAndPort& server,
                                               std::chrono::steady_clock::time_point deadline);

/// Tries `count` places one by one until one can be reached. Each but the last gets a share of what
/// is left of the time: one that never answers leaves time for the others.
boost::system::error_code try_in_turn(
    std::size_t count, const WaitLimit& limit,
    const std::function<boost::system::error_code(std::size_t place, const WaitLimit& share)>&
        attempt);

/// What HTTP calls the other end: of TCP its address, by which it always answers.
std::string host_of(const ControlConnection& connection);

/// What the operator is to do about it.
std::string explain(const std::string& place, const boost::system::error_code& error);

}  // namespace mbgate::ctl
