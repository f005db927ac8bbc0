// SPDX-License-Identifier: Apache-2.0
// The writing of a recording: appends to a string of the caller's, which keeps its memory.
#include "gateway/recording/record.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <fmt/core.h>

namespace mbgate::gateway {
namespace {

template <typename Number>
void append_number(std::string& out, Number number) {
  std::array<char, 24> digits{};
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), number).ptr;
  out.append(digits.data(), end);
}

void append_hex(std::string& out, modbus::Bytes bytes) {
  constexpr std::string_view kDigits = "0123456789ABCDEF";
  std::size_t at = out.size();
  out.resize(at + 2 * bytes.size());
  for (const std::uint8_t byte : bytes) {
    out[at++] = kDigits[byte >> 4U];
    out[at++] = kDigits[byte & 0xFU];
  }
}

std::string_view word_of(bus::LineKind kind) {
  switch (kind) {
    case bus::LineKind::uart: return "uart";
    case bus::LineKind::adapter: return "adapter";
    case bus::LineKind::virtual_line: return "virtual";
  }
  return "";
}

/// The words of one line, apart from its beginning.
struct Words {
  std::string& out;

  Words& word(std::string_view text) {
    out += ' ';
    out += text;
    return *this;
  }
  Words& number(std::uint64_t value) {
    out += ' ';
    append_number(out, value);
    return *this;
  }
  /// Nothing for a client without TLS. Names are written as hexadecimal bytes of UTF-8: they may
  /// have spaces.
  void role(const routing::ClientRole& role) {
    switch (role.kind) {
      case routing::ClientRole::Kind::none: break;
      case routing::ClientRole::Kind::unreadable: word("no-role"); break;
      case routing::ClientRole::Kind::named:
        word("role").hex(std::vector<std::uint8_t>(role.name.begin(), role.name.end()));
        break;
    }
    if (!role.certificate.empty()) {
      const std::string& name = role.certificate;
      word("certificate").hex(std::vector<std::uint8_t>(name.begin(), name.end()));
    }
  }
  Words& client(ClientId id) { return number(static_cast<std::uint64_t>(id)); }
  Words& bus(BusId id) { return number(static_cast<std::uint64_t>(id)); }
  Words& hex(modbus::Bytes bytes) {
    out += ' ';
    append_hex(out, bytes);
    return *this;
  }
};

struct InputWords {
  Words words;

  void operator()(const ClientConnected& input) {
    words.word("connected").client(input.client);
    words.number(static_cast<std::uint64_t>(input.info.listener));
    words.word(input.info.address.to_text());
    const auto& since = input.info.waits_since;
    const Duration shown = since ? std::max(since->time_since_epoch(), Duration{1}) : Duration{0};
    words.number(static_cast<std::uint64_t>(shown.count()));
    words.role(input.info.role);
  }
  void operator()(const ClientBytes& input) {
    words.word("read").client(input.client).number(input.unread).hex(input.bytes);
  }
  void operator()(const ClientSent& input) { words.word("sent").client(input.client); }
  void operator()(const ClientHalfClosed& input) { words.word("fin").client(input.client); }
  void operator()(const ClientDisconnected& input) {
    words.word("gone").client(input.client);
    if (!input.bytes.empty()) {
      words.hex(input.bytes);
    }
  }
  void operator()(const LineOpened& input) {
    words.word("opened").bus(input.bus).word(word_of(input.kind));
  }
  void operator()(const LineBytes& input) { words.word("line").bus(input.bus).hex(input.bytes); }
  void operator()(const LineUnsent& input) {
    words.word("unsent").bus(input.bus).number(input.bytes);
  }
  void operator()(const LineLost& input) {
    words.word(input.loss == bus::Loss::closed ? "closed" : "lost").bus(input.bus);
  }
  void operator()(const LineLooked& input) { words.word("looked").bus(input.bus); }
  void operator()(const DeadlineReached& /*input*/) { words.word("time"); }
  void operator()(const SettingsChanged& /*input*/) { words.word("settings"); }
  void operator()(const Stalled& input) {
    words.word("stalled").number(static_cast<std::uint64_t>(input.lasted.count()));
  }
  void operator()(const ClearCountersAsked& /*input*/) { words.word("clear"); }
  void operator()(const ShutdownAsked& /*input*/) { words.word("shutdown"); }
};

struct ActionWords {
  Words words;
  const Settings& settings;

  void operator()(const Send& action) {
    words.word("send").client(action.client).hex({action.adu.data(), action.adu.size()});
  }
  void operator()(const Pause& action) { words.word("pause").client(action.client); }
  void operator()(const Resume& action) { words.word("resume").client(action.client); }
  void operator()(const Close& action) { words.word("close").client(action.client); }
  void operator()(const Open& action) { words.word("open").bus(action.bus); }
  void operator()(const Look& action) { words.word("look").bus(action.bus); }
  void operator()(const Transmit& action) {
    words.word("transmit").bus(action.bus).hex({action.frame.data(), action.frame.size()});
  }
  void operator()(const Shut& action) { words.word("shut").bus(action.bus); }
  void operator()(const Report& action) {
    words.word("report").word(to_text(action.event, settings));
  }
  void operator()(const Finished& /*action*/) { words.word("finished"); }
};

}  // namespace

void append_line(std::string& out, const Input& input, Instant at) {
  if (const auto* changed = std::get_if<SettingsChanged>(&input)) {
    out += changed->config;
  }
  append_number(out, at.time_since_epoch().count());
  std::visit(InputWords{{out}}, input);
  out += '\n';
}

void append_line(std::string& out, const Action& action, const Settings& settings) {
  out += '<';
  std::visit(ActionWords{{out}, settings}, action);
  out += '\n';
}

void append_start(std::string& out, Instant start) {
  append_number(out, start.time_since_epoch().count());
  out += " start\n";
}

void append_end(std::string& out, std::string_view why) { ((out += "end ") += why) += '\n'; }

std::string config_lines(const std::vector<ConfigFile>& files) {
  std::string out;
  for (const auto& file : files) {
    out += fmt::format("config {}\n", file.path);
    const std::string_view text = file.text;
    for (std::size_t begin = 0; begin < text.size();) {
      const std::size_t end = std::min(text.find('\n', begin), text.size());
      ((out += "| ") += text.substr(begin, end - begin)) += '\n';
      begin = end + 1;
    }
  }
  return out;
}

std::string head_lines(const RecordingHead& head) {
  std::string out = fmt::format("mbgate recording 1\nversion {}\n", head.version);
  if (!head.profiles.empty()) {
    out += fmt::format("profiles {}\n", head.profiles);
  }
  return out + config_lines(head.config);
}

}  // namespace mbgate::gateway
