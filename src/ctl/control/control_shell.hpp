// SPDX-License-Identifier: Apache-2.0
// Asks a running mbgated, over its control socket.
#pragma once

#include <boost/json/object.hpp>
#include <chrono>
#include <string>

#include "modbus/result.hpp"

namespace mbgate::ctl {

struct ControlAnswer {
  unsigned status = 0;  ///< of HTTP
  boost::json::object json;
};

/// `method`: "GET" or "POST". `limit`: for all of it. The error is a sentence that
/// says what to do.
Result<ControlAnswer, std::string> ask_control(const std::string& socket, const std::string& method,
                                               const std::string& target,
                                               std::chrono::seconds limit);

}  // namespace mbgate::ctl
