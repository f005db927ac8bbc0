// SPDX-License-Identifier: Apache-2.0
#include "ctl/profile/profile_text.hpp"

#include <algorithm>
#include <fmt/core.h>
#include <ostream>
#include <utility>

#include "base/text.hpp"
#include "config/profiles/profile_entries.hpp"
#include "config/profiles/profile_library.hpp"
#include "config/toml/match_entry.hpp"
#include "config/toml/toml_value.hpp"
#include "ctl/request/carry_out.hpp"
#include "ctl/visible_text.hpp"

namespace mbgate::ctl {
namespace {

using config::ProfileFile;
using config::Source;
using config::to_text;
using drive::WriteMatch;
using modbus::Table;
using Rows = std::vector<std::vector<std::string>>;

std::string name_text(const Source& source, std::string_view besides = {}) {
  std::string text = source.name;
  for (const std::string_view more : {besides, std::string_view(source.note)}) {
    if (!more.empty()) {
      text.append(text.empty() ? "" : "; ").append(more);
    }
  }
  return text;
}

/// "4", "4-5"; as a manual prints them "40005", "40005-40006".
std::string address_text(const drive::TableRange& range) {
  const auto first = std::to_string(range.first);
  return range.count == 1 ? first : fmt::format("{}-{}", first, drive::end_of(range) - 1);
}
void add_section(std::string& text, std::string_view title, Rows rows,
                 std::vector<std::string> header) {
  if (rows.empty()) {
    return;
  }
  rows.insert(rows.begin(), std::move(header));
  text += fmt::format("\n{}\n{}", title, columns(rows));
}

template <typename Match>
std::string condition(Table table, const Match& match) {
  if (table == Table::coils) {
    return (match.value == 0) == match.other ? "on" : "off";
  }
  const std::string masked =
      match.mask == Match().mask ? "" : fmt::format("& {} ", hex(match.mask));
  return fmt::format("{}{}{}", masked, match.other ? "other than " : "= ", hex(match.value));
}

std::vector<std::string> match_cells(const ProfileFile& file, const WriteMatch& match) {
  const drive::TableRange range{match.table, match.address, 1};
  const std::string parameters =
      match.parameters == 0 ? "" : fmt::format(", with up to {} parameters", match.parameters);
  return {address_text(range), number_text(file, range),
          condition(match.table, match) + parameters};
}

void add_writes(std::string& text, const ProfileFile& file) {
  Rows rows;
  for (const auto& [stop, source] : file.stops) {
    rows.push_back(match_cells(file, stop));
    rows.back().insert(rows.back().end(), {line_text(source.line), name_text(source)});
  }
  add_section(text, "Stop commands", std::exchange(rows, {}),
              {"address", "manual", "written", "line", "name"});
  for (const auto& [unanswered, source] : file.unanswered) {
    rows.push_back(match_cells(file, unanswered.match));
    rows.back().insert(rows.back().end(),
                       {to_text(unanswered.after), line_text(source.line), name_text(source)});
  }
  add_section(text, "Writes that are never answered", std::exchange(rows, {}),
              {"address", "manual", "written", "deaf for", "line", "name"});
  for (const auto& [slow, source] : file.slow) {
    rows.push_back({std::string(config::table_word(slow.range.table)), address_text(slow.range),
                    number_text(file, slow.range), to_text(slow.response_timeout),
                    line_text(source.line), name_text(source)});
  }
  add_section(text, "Slow registers", std::move(rows),
              {"table", "address", "manual", "response timeout", "line", "name"});
}

void add_ranges(std::string& text, const ProfileFile& file, std::string_view title,
                const config::DocumentedRanges& ranges) {
  Rows rows;
  for (const auto& [range, source] : ranges) {
    rows.push_back({std::string(config::table_word(range.table)), address_text(range),
                    number_text(file, range), line_text(source.line), name_text(source)});
  }
  add_section(text, title, std::move(rows), {"table", "address", "manual", "line", "name"});
}

void add_communication(std::string& text, const ProfileFile& file) {
  add_ranges(text, file, "Communication registers, guarded unless allow_reconfigure = true",
             file.communication);
  Rows rows;
  for (const auto& [guarded, source] : file.guarded) {
    rows.push_back({std::string(config::table_word(guarded.range.table)),
                    address_text(guarded.range), number_text(file, guarded.range),
                    condition(guarded.range.table, guarded), line_text(source.line),
                    name_text(source)});
  }
  add_section(text, "Writes that are guarded like them", std::move(rows),
              {"table", "address", "manual", "written", "line", "name"});
}

void add_opcodes(std::string& text, const ProfileFile& file) {
  if (const auto& opcodes = file.profile.position_opcodes) {
    text += "\nOpcodes with a position (word order: opcode_order of the device)\n" +
            columns({{"opcode in", file.number(Table::holding_registers, opcodes->address)},
                     {"opcodes", joined(opcodes->opcodes, hex)},
                     {"position from",
                      file.number(Table::holding_registers, opcodes->position) +
                          (file.position_opcodes_line
                               ? fmt::format(" (line {})", line_text(file.position_opcodes_line))
                               : "")}});
  }
}

void add_values(std::string& text, const ProfileFile& file, Table table, unsigned registers) {
  Rows rows;
  for (const auto& [value, access, source] : file.values) {
    if (value.table == table && value.registers == registers) {
      rows.push_back({std::to_string(value.first), file.number(table, value.first),
                      std::string(config::word_for(config::kAccesses, access)),
                      line_text(source.line),
                      name_text(source, value.motion ? "starts motion" : "")});
    }
  }
  const auto title =
      fmt::format("{}-bit values in {}: {}", 16 * registers, table_name(table), rows.size());
  add_section(text, title, std::move(rows), {"address", "manual", "access", "line", "name"});
}

int show(const config::ProfileFile& file, bool as_json, std::ostream& out) {
  out << (as_json ? profile_json(file) + "\n" : profile_text(file));
  return kExitDone;
}

int show_file(const ProfileCommand& command, std::ostream& out, std::ostream& errors) {
  const auto loaded = config::load_profile(config::read_text_file(command.which));
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
  const auto files = all_profiles(library);
  Rows rows;
  for (const auto* file : files) {
    rows.push_back({file->profile.name, file->description});
  }
  out << (as_json ? profiles_json(files) + "\n" : columns(rows));
  errors << config::render(library.diagnostics());
  return config::has_errors(library.diagnostics()) ? kExitNotDone : kExitDone;
}

}  // namespace

std::string profile_text(const config::ProfileFile& file) {
  std::string text = profile_head(file);
  add_writes(text, file);
  add_communication(text, file);
  add_opcodes(text, file);
  for (const unsigned registers : {2U, 4U}) {
    for (const auto table : {Table::holding_registers, Table::input_registers}) {
      add_values(text, file, table, registers);
    }
  }
  add_ranges(text, file, "Write-only registers besides values", file.write_only);
  add_ranges(text, file, "Strings, never exchanged", file.strings);
  add_ranges(text, file, "Parameter groups (no request crosses a border)", file.groups);
  return text;
}

std::vector<const config::ProfileFile*> all_profiles(config::ProfileLibrary& library) {
  std::vector<const config::ProfileFile*> files;
  for (const auto& name : library.names()) {
    if (const auto* file = library.find(name)) {
      files.push_back(file);
    }
  }
  return files;
}

int run(const ProfileCommand& command, std::ostream& out, std::ostream& errors) {
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
