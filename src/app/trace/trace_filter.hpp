// SPDX-License-Identifier: Apache-2.0
// Selects the records of a trace that a reader asks for.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "gateway/trace/trace_record.hpp"
#include "modbus/result.hpp"

namespace mbgate::app {

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
