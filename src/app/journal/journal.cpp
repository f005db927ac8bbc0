// SPDX-License-Identifier: Apache-2.0
#include "app/journal/journal.hpp"

#include <fmt/core.h>

// An entry is about the plant; which line of the source wrote it is of no use to an operator.
#define SD_JOURNAL_SUPPRESS_LOCATION
#include <sys/stat.h>
#include <sys/uio.h>
#include <systemd/sd-journal.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <span>

namespace mbgate::app {
namespace {

/// Where sd_journal_sendv() sends to. It reports success where the socket does not exist.
constexpr const char* kSocket = "/run/systemd/journal/socket";

/// More than journal_fields() gives.
constexpr std::size_t kMostFields = 16;

}  // namespace

bool is_standard_error_the_journal() {
  const char* const stream = std::getenv("JOURNAL_STREAM");
  struct stat status {};
  if (stream == nullptr || ::fstat(STDERR_FILENO, &status) != 0) {
    return false;
  }
  return fmt::format("{}:{}", status.st_dev, status.st_ino) == stream;
}

bool send_to_journal(const std::vector<std::string>& fields) {
  if (::access(kSocket, F_OK) != 0) {
    return false;
  }
  std::array<iovec, kMostFields> parts{};
  int count = 0;
  for (const std::string& field : std::span(fields).first(std::min(fields.size(), parts.size()))) {
    // Only read there.
    parts[static_cast<std::size_t>(count++)] = {const_cast<char*>(field.data()), field.size()};
  }
  return ::sd_journal_sendv(parts.data(), count) >= 0;
}

std::vector<std::string> journal_fields(Level level, const std::string& text, const Topic& topic) {
  std::vector<std::string> fields{
      "MESSAGE=" + text, fmt::format("PRIORITY={}", static_cast<int>(level)),
      "SYSLOG_IDENTIFIER=mbgated",
      "SYSLOG_FACILITY=3",  // daemon, as systemd says of what is written to standard error
  };
  const auto add = [&](const char* name, std::string_view value) {
    if (!value.empty()) {
      fields.push_back(fmt::format("{}={}", name, value));
    }
  };
  add("MESSAGE_ID", topic.id.hex);
  add("MBGATE_BUS", topic.bus);
  add("MBGATE_DEVICE", topic.device);
  add("MBGATE_ADDRESS", topic.address);
  add("MBGATE_CLIENT", topic.client);
  add("MBGATE_LISTENER", topic.listener);
  add("MBGATE_ROLE", topic.role);
  add("MBGATE_CERTIFICATE", topic.certificate);
  add("MBGATE_UNIT", topic.unit);
  add("MBGATE_FUNCTION", topic.function);
  return fields;
}

}  // namespace mbgate::app
