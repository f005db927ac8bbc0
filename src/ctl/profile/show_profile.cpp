// SPDX-License-Identifier: Apache-2.0
#include <ostream>

#include "config/profiles/profile_library.hpp"
#include "ctl/profile/profile_json.hpp"
#include "ctl/profile/profile_text.hpp"
#include "ctl/request/carry_out.hpp"

namespace mbgate::ctl {
namespace {

int show(const config::ProfileFile& file, bool as_json, std::ostream& out) {
  out << (as_json ? profile_json(file) + "\n" : profile_text(file));
  return kExitDone;
}

int show_file(const ProfileCommand& command, std::ostream& out, std::ostream& errors) {
  const auto loaded = config::load_profile(command.which);
  errors << config::render(loaded.diagnostics);
  return loaded.file ? show(*loaded.file, command.json, out) : kExitNotDone;
}

int show_named(const ProfileCommand& command, config::ProfileLibrary& library, std::ostream& out,
               std::ostream& errors) {
  if (!library.knows(command.which)) {
    errors << "mbgatectl: " << unknown_profile(library, command.which) << '\n';
    return kExitNotDone;
  }
  const auto* file = library.find(command.which);
  errors << config::render(library.diagnostics());
  return file == nullptr ? kExitNotDone : show(*file, command.json, out);
}

int list(config::ProfileLibrary& library, bool as_json, std::ostream& out, std::ostream& errors) {
  std::vector<ProfileTitle> titles;
  std::vector<std::vector<std::string>> rows;
  for (const auto& name : library.names()) {
    if (const auto* file = library.find(name)) {
      titles.push_back({name, file->description});
      rows.push_back({name, file->description});
    }
  }
  out << (as_json ? profiles_json(titles) + "\n" : columns(rows));
  errors << config::render(library.diagnostics());
  return config::has_errors(library.diagnostics()) ? kExitNotDone : kExitDone;
}

}  // namespace

int show_profile(const ProfileCommand& command, std::ostream& out, std::ostream& errors) {
  const bool names_file =
      command.which.find('/') != std::string::npos || command.which.ends_with(".toml");
  if (names_file) {
    return show_file(command, out, errors);
  }
  config::ProfileLibrary library(command.folder ? config::ProfileFolders{*command.folder}
                                                : config::default_profile_folders());
  return command.which.empty() ? list(library, command.json, out, errors)
                               : show_named(command, library, out, errors);
}

}  // namespace mbgate::ctl
