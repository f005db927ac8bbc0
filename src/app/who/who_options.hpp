// SPDX-License-Identifier: Apache-2.0
// `mbgated --check --who ADDRESS --unit N --write holding 124`: what would become of this request,
// and what decides. The gateway's own parts answer (gateway/access/who).
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "config/diagnostic.hpp"
#include "gateway/settings.hpp"
#include "modbus/result.hpp"

namespace mbgate::app {

/// As they stand on the command line.
struct WhoOptions {
  std::string client{};
  std::optional<std::string> listener{};  ///< none: each
  std::optional<std::string>
      role{};                 ///< of its certificate, where there is TLS; none: the NULL role
  std::string certificate{};  ///< the name of its certificate, there
  unsigned unit = 0;
  std::vector<std::string> read{};   ///< table and address
  std::vector<std::string> write{};  ///< the same
  unsigned count = 1;
  unsigned value = 0;  ///< that is written, to each register
};

struct WhoAnswers {
  bool any_permitted = false;  ///< on one of the listeners
  std::string text;            ///< a line for each listener
};

/// An error names the option, and what would be right. `places`: of these settings.
[[nodiscard]] Result<WhoAnswers, std::string> answer_who(const gateway::Settings& settings,
                                                         const config::KeyPlaces& places,
                                                         const WhoOptions& options);

}  // namespace mbgate::app
