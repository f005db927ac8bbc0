// SPDX-License-Identifier: Apache-2.0
// The way to systemd's journal.
#pragma once

#include <string>
#include <vector>

namespace mbgate::app {

/// Is standard error the stream that systemd connected to the journal (JOURNAL_STREAM in
/// systemd.exec)?
bool is_standard_error_the_journal();

/// One entry, "FIELD=value" each. Waits as long as the journal takes nothing. False if there is no
/// journal to take it.
bool send_to_journal(const std::vector<std::string>& fields);

}  // namespace mbgate::app
