// SPDX-License-Identifier: Apache-2.0
#include "config/load.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

#include "config/sections/sections.hpp"

namespace mbgate::config {
namespace {

Loaded read(TomlDocument document, ProfileSearch search) {
  Loaded loaded;
  std::vector<Diagnostic> of_profiles;
  if (document.parsed()) {
    Draft draft(document, std::move(search.otherwise));
    // Names must be known before something refers to them.
    read_gateway(draft, search.folder);
    read_tls(draft);
    read_buses(draft);
    read_devices(draft);
    read_listeners(draft);
    read_http(draft);
    read_routes(draft);
    read_clients(draft);
    read_rules(draft);
    check_whole(draft);
    if (!document.failed()) {
      loaded.places = find_key_places(draft);
    }
    loaded.settings = std::move(draft.settings);
    of_profiles = draft.library.diagnostics();
    loaded.profiles = draft.library.files();
  }
  loaded.diagnostics = document.finish();
  std::ranges::move(of_profiles, std::back_inserter(loaded.diagnostics));
  if (has_errors(loaded.diagnostics)) {
    loaded.settings.reset();
  }
  return loaded;
}

}  // namespace

Loaded load_settings(const std::filesystem::path& path, ProfileSearch search) {
  return load_settings(read_config_files(path), std::move(search));
}

Loaded load_settings(const std::vector<TextFile>& files, ProfileSearch search) {
  return read(TomlDocument::parse(files), std::move(search));
}

}  // namespace mbgate::config
