// SPDX-License-Identifier: Apache-2.0
// A trace as JSON (docs/api.yaml).
#pragma once

#include <boost/json/object.hpp>
#include <chrono>
#include <string>

#include "gateway/trace/trace_record.hpp"

namespace mbgate::app {

/// "transaction" (a request, from the client and back), "frame" (on the wire, for no request that
/// is traced) or "heard" (bytes that nobody had asked for).
const char* trace_kind(const gateway::TraceRecord& record);

/// `epoch`: the time of day at the machine's instant 0.
boost::json::object trace_json(const gateway::TraceRecord& record,
                               std::chrono::system_clock::time_point epoch);

}  // namespace mbgate::app
