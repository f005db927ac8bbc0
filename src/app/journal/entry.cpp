// SPDX-License-Identifier: Apache-2.0
#include "app/journal/entry.hpp"

namespace mbgate::app {

std::vector<std::string> journal_fields(Level level, const std::string& text, const Topic& topic) {
  std::vector<std::string> fields{
      "MESSAGE=" + text, "PRIORITY=" + std::to_string(static_cast<int>(level)),
      "SYSLOG_IDENTIFIER=mbgated",
      "SYSLOG_FACILITY=3",  // daemon, as systemd says of what is written to standard error
  };
  const auto add = [&](const char* name, std::string_view value) {
    if (!value.empty()) {
      fields.push_back(std::string(name) + '=' + std::string(value));
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
