// SPDX-License-Identifier: Apache-2.0
// A trace as JSON (docs/api.yaml).
#pragma once

#include <boost/json/object.hpp>
#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "gateway/trace/trace_record.hpp"
#include "modbus/result.hpp"

namespace mbgate::app {

/// "transaction" (a request, from the client and back), "frame" (on the wire, for no request that
/// is traced) or "heard" (bytes that nobody had asked for).
const char* trace_kind(const gateway::TraceRecord& record);

/// `epoch`: the time of day at the machine's instant 0.
boost::json::object trace_json(const gateway::TraceRecord& record,
                               std::chrono::system_clock::time_point epoch);

/// Selects the records of a trace that a reader asks for.
struct TraceFilter {
  std::optional<std::string> bus;     ///< name; it was to go there, or was heard there
  std::optional<std::string> device;  ///< name; it was to go there
  std::optional<routing::ClientAddress> client;
  std::optional<std::uint8_t> function;  ///< of the request
  bool only_failed = false;
  bool with_journal = false;  ///< what the journal gets comes too

  /// `query`: what stands behind the '?' of a request. The error names the word, and says what is
  /// expected.
  static Result<TraceFilter, std::string> parse(std::string_view query);

  /// A record that does not say what is asked for does not match: bytes that nobody had asked for
  /// have no client.
  [[nodiscard]] bool matches(const gateway::TraceRecord& record) const;
};

}  // namespace mbgate::app
