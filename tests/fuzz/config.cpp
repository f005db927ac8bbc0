// SPDX-License-Identifier: Apache-2.0
// Any text as a configuration: settings that a gateway can be made of, or diagnostics.
#include <string_view>

#include "fuzz/fuzz.hpp"
#include "support/config_text.hpp"
#include "support/gateway_harness.hpp"

namespace mbgate::fuzz::config_target {

MBGATE_FUZZ_TARGET(config) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  config::ProfileSearch search;
  search.folder = MBGATE_SOURCE_DIR "/tests/config/profiles";
  auto loaded = test::load_settings_text("fuzz.toml", text, search);
  require(loaded.settings.has_value() != config::has_errors(loaded.diagnostics),
          "settings, or errors that say why not");
  require(config::render(loaded.diagnostics).empty() == loaded.diagnostics.empty(),
          "every diagnostic says something");
  if (loaded.settings && loaded.settings->buses.size() < 100) {
    test::GatewayHarness harness(*std::move(loaded.settings), gateway::Instant{});
    std::size_t lines = 0;
    harness.drain([&](const gateway::Action& action) {
      lines += std::holds_alternative<gateway::Open>(action) ? 1U : 0U;
    });
    require(lines == harness.settings().buses.size(), "a gateway asks for every line");
  }
  return 0;
}

}  // namespace mbgate::fuzz::config_target
