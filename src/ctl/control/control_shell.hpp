// SPDX-License-Identifier: Apache-2.0
// Sends requests to a running mbgated over its control socket, or over TCP for requests that TCP
// permits (connection_shell explains the places).
#pragma once

#include <boost/json/object.hpp>
#include <chrono>
#include <exception>
#include <functional>
#include <string>
#include <string_view>

#include "ctl/request/repetition.hpp"
#include "modbus/result.hpp"

namespace mbgate::ctl {

struct ControlAnswer {
  unsigned status = 0;  ///< of HTTP
  boost::json::object json;
};

inline constexpr unsigned kControlOk = 200;

/// What mbgated says of a question that it did not answer as asked.
std::string error_of(const ControlAnswer& answer);

/// The sentence for what was thrown because an answer is not what this version expects.
std::string other_version(const std::exception& exception);

/// `method`: "GET" or "POST". `limit`: for all of it. `give_up` is called every now and then until
/// the answer is there; when it returns true, the question is left off. The error is a sentence
/// that says what to do.
Result<ControlAnswer, std::string> ask_control(const std::string& place, const std::string& method,
                                               const std::string& target,
                                               std::chrono::seconds limit,
                                               const std::function<bool()>& give_up = {});

/// Gives the answer to a GET to `take` piece by piece, as long as it goes on and `take` returns
/// true. Meanwhile a signal ends the process with status 0, but not while `take` runs. Returns why
/// it has ended, a sentence; nothing if `take` returned false.
std::string follow_control(const std::string& place, const std::string& target,
                           const Interruption& interruption,
                           const std::function<bool(std::string_view)>& take);

}  // namespace mbgate::ctl
