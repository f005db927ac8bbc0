// SPDX-License-Identifier: Apache-2.0
#include "config/load.hpp"

#include <utility>

#include "config/sections.hpp"

namespace mbgate::config {
namespace {

Loaded read(TomlDocument document) {
  Loaded loaded;
  if (document.parsed()) {
    Draft draft(document);
    // Names must be known before something refers to them.
    read_gateway(draft);
    read_buses(draft);
    read_devices(draft);
    read_listeners(draft);
    read_routes(draft);
    check_whole(draft);
    loaded.settings = std::move(draft.settings);
  }
  loaded.diagnostics = document.finish();
  if (has_errors(loaded.diagnostics)) {
    loaded.settings.reset();
  }
  return loaded;
}

}  // namespace

Loaded load_settings(const std::filesystem::path& path) { return read(TomlDocument::load(path)); }

Loaded load_settings_text(std::string name, std::string_view text) {
  return read(TomlDocument::parse(std::move(name), text));
}

}  // namespace mbgate::config
