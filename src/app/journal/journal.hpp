// SPDX-License-Identifier: Apache-2.0
// Sends entries to systemd's journal.
//
// To change
// - a line in the journal: its text: report/event_text; the priority and the rate of its event:
//   event_topic; writing it: app/log; its fields, and sending it to systemd: journal.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "app/journal/message_id.hpp"

namespace mbgate::app {

/// Is standard error the stream that systemd connected to the journal (JOURNAL_STREAM in
/// systemd.exec)?
bool is_standard_error_the_journal();

/// One entry, "FIELD=value" each. Waits as long as the journal takes nothing. False if there is no
/// journal to take it.
bool send_to_journal(const std::vector<std::string>& fields);

// An entry of the journal as its fields, which `journalctl MBGATE_BUS=axes` and `journalctl -x`
// use.

/// The numbers are those of syslog(3).
enum class Level : std::uint8_t { error = 3, warning = 4, notice = 5, info = 6 };

/// What an entry is about, as far as there is such a thing.
struct Topic {
  MessageId id{};
  std::string bus{};
  std::string device{};   ///< of the configuration
  std::string address{};  ///< of the device on its bus
  std::string client{};   ///< its address
  std::string listener{};
  std::string role{};         ///< of the client's certificate
  std::string certificate{};  ///< its name
  std::string unit{};         ///< that it asks
  std::string function{};
};

/// "MESSAGE=text" and the others; those of the topic that are empty are left out.
std::vector<std::string> journal_fields(Level level, const std::string& text, const Topic& topic);

}  // namespace mbgate::app
