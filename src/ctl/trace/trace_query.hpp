// SPDX-License-Identifier: Apache-2.0
// What mbgated is asked for a trace.
#pragma once

#include <string>

#include "ctl/request/command.hpp"

namespace mbgate::ctl {

/// "/api/v1/trace?bus=line-a&only=failed"; what is not a letter, digit or one of -._~ goes as the
/// percent-encoded octets of its UTF-8 (RFC 3986, 2.1).
std::string trace_target(const TraceFilter& filter);

}  // namespace mbgate::ctl
