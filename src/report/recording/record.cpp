// SPDX-License-Identifier: Apache-2.0
// The lines of inputs and actions. visit_fields() describes them for reading and writing alike. The
// text that is read comes from outside: every line is checked whole.
#include "report/recording/record.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <fmt/core.h>
#include <optional>
#include <type_traits>

#include "base/text.hpp"
#include "gateway/limits.hpp"
#include "report/text.hpp"

namespace mbgate::report {
namespace {

using namespace gateway;

/// In the order of the variant; then that of a line which its far end has closed.
constexpr std::array kInputWords{"connected", "read",   "sent",     "fin",    "gone", "opened",
                                 "line",      "unsent", "lost",     "looked", "time", "settings",
                                 "stalled",   "clear",  "shutdown", "closed"};
constexpr std::size_t kInputs = std::variant_size_v<Input>;
static_assert(kInputWords.size() == kInputs + 1);
/// In the order of the variant.
constexpr std::array kActionWords{"send", "pause",    "resume", "close",  "open",
                                  "look", "transmit", "shut",   "report", "finished"};
static_assert(kActionWords.size() == std::variant_size_v<Action>);

constexpr std::array kLineKinds{"uart", "adapter", "virtual"};  // by bus::LineKind
constexpr std::array kRoleWords{"role", "no-role"};
constexpr std::string_view kDigits = "0123456789ABCDEF";

/// What stands behind the word of an input or action, in its order in the line.
template <typename Line, typename Entry>
void visit_fields(Line& line, Entry& entry) {
  if constexpr (requires { entry.client; }) {
    line.number(entry.client, "the number of a client");
  } else if constexpr (requires { entry.bus; }) {
    line.number(entry.bus, "the place of a bus");
  }
  if constexpr (requires { entry.info; }) {
    line.number(entry.info.listener, "the place of a listener");
    line.address(entry.info.address);
    line.since(entry.info.waits_since);
    line.role(entry.info.role);
  } else if constexpr (requires { entry.unread; }) {
    line.number(entry.unread, "a number of bytes");
    line.bytes(entry.bytes, kClientReadSize);
  } else if constexpr (requires {
                         entry.client;
                         entry.bytes;
                       }) {
    line.last_bytes(entry.bytes, kClientLastSize);
  } else if constexpr (requires { entry.bytes.size(); }) {
    line.bytes(entry.bytes);
  } else if constexpr (requires { entry.bytes; }) {
    line.number(entry.bytes, "a number of bytes");
  } else if constexpr (requires { entry.kind; }) {
    line.kind(entry.kind);
  } else if constexpr (requires { entry.lasted; }) {
    line.lasted(entry.lasted);
  } else if constexpr (requires { entry.adu; }) {
    line.bytes(entry.adu);
  } else if constexpr (requires { entry.frame; }) {
    line.bytes(entry.frame);
  }
}

template <typename Number>
void append_number(std::string& out, Number number) {
  std::array<char, 24> digits{};
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), number).ptr;
  out.append(digits.data(), end);
}

/// Appends the fields of a line, each after one space.
struct LineWriter {
  std::string& out;

  void word(std::string_view text) { (out += ' ') += text; }
  template <typename Number>
  void number(Number value, std::string_view /*wanted*/ = {}) {
    out += ' ';
    append_number(out, static_cast<std::uint64_t>(value));
  }
  void address(const routing::ClientAddress& address) { word(address.to_text()); }
  void since(const std::optional<Instant>& since) {
    number(since ? std::max(since->time_since_epoch(), Duration{1}).count() : 0);
  }
  void kind(bus::LineKind kind) { word(kLineKinds.at(static_cast<std::size_t>(kind))); }
  void lasted(std::chrono::milliseconds lasted) { number(lasted.count()); }
  void bytes(const auto& bytes, std::size_t /*most*/ = 0) {
    out += ' ';
    for (const auto byte : bytes) {
      out += kDigits[static_cast<std::uint8_t>(byte) >> 4U];
      out += kDigits[static_cast<std::uint8_t>(byte) & 0xFU];
    }
  }
  void last_bytes(modbus::Bytes data, std::size_t /*most*/) {
    if (!data.empty()) {
      bytes(data);
    }
  }
  /// Nothing for a client without TLS. Names are written as hexadecimal bytes of UTF-8: they may
  /// have spaces.
  void role(const routing::ClientRole& role) {
    using Kind = routing::ClientRole::Kind;
    if (role.kind == Kind::named) {
      word("role");
      bytes(role.name);
    } else if (role.kind == Kind::unreadable) {
      word("no-role");
    }
    if (!role.certificate.empty()) {
      word("certificate");
      bytes(role.certificate);
    }
  }
};

/// Takes the fields of a line one by one, each after one space; the first wrong one is kept as the
/// error.
class LineReader {
 public:
  LineReader(std::string_view line, std::vector<std::uint8_t>& storage)
      : rest_(line), storage_(storage) {}

  std::string_view next(std::string_view wanted) {
    if (ended_ && error_.empty()) {
      error_ = fmt::format("expected {} at the end of the line", wanted);
    }
    const std::size_t space = rest_.find(' ');
    const std::string_view word = rest_.substr(0, space);
    ended_ = space == std::string_view::npos;
    rest_ = ended_ ? std::string_view() : rest_.substr(space + 1);
    return word;
  }
  template <typename Number>
  void number(Number& number, std::string_view wanted) {
    const std::string_view word = next(wanted);
    if constexpr (std::is_enum_v<Number>) {
      take(number, integer_in<std::underlying_type_t<Number>>(word), wanted, word);
    } else {
      take(number, integer_in<Number>(word), wanted, word);
    }
  }
  void address(routing::ClientAddress& address) {
    const std::string_view word = next("an address");
    take(address, routing::ClientAddress::parse(word), "an address", word);
  }
  void since(std::optional<Instant>& since) {
    std::int64_t nanoseconds = 0;
    number(nanoseconds, "an instant in nanoseconds");
    if (nanoseconds > 0) {
      since = nanoseconds == 1 ? Instant::min() : Instant(Duration(nanoseconds));
    }
  }
  void kind(bus::LineKind& kind) {
    kind = static_cast<bus::LineKind>(choice(kLineKinds, "uart, adapter or virtual"));
  }
  void lasted(std::chrono::milliseconds& lasted) {
    std::uint32_t milliseconds = 0;
    number(milliseconds, "a number of milliseconds");
    lasted = std::chrono::milliseconds(milliseconds);
  }
  void bytes(modbus::Bytes& bytes, std::size_t most = std::string_view::npos) {
    bytes = hex();
    if (bytes.size() > most) {
      wrong(fmt::format("at most {} bytes", most), fmt::format("{} bytes", bytes.size()));
    }
  }
  /// That may be missing.
  void last_bytes(modbus::Bytes& data, std::size_t most) {
    if (!ended_) {
      bytes(data, most);
    }
  }
  void role(routing::ClientRole& role) {
    using Kind = routing::ClientRole::Kind;
    if (ended_) {
      return;
    }
    if (choice(kRoleWords, "role or no-role") == 0) {
      role = {Kind::named, text()};
    } else {
      role.kind = Kind::unreadable;
    }
    if (!ended_) {
      choice(std::array{"certificate"}, "certificate");
      role.certificate = text();
    }
  }
  /// Which of these words comes next; the first if none of them does.
  std::size_t choice(const auto& words, std::string_view wanted) {
    const std::string_view word = next(wanted);
    const auto known = std::ranges::find(words, word);
    if (known == words.end()) {
      wrong(wanted, word);
      return 0;
    }
    return static_cast<std::size_t>(known - words.begin());
  }
  void wrong(std::string_view wanted, std::string_view found) {
    if (error_.empty()) {
      error_ = fmt::format("expected {}, found \"{}\"", wanted, found);
    }
  }
  /// What was wrong, or nothing if the line ends here.
  std::string error() {
    if (!ended_) {
      wrong("the end of the line", rest_);
    }
    return error_;
  }

 private:
  void take(auto& field, const auto& found, std::string_view wanted, std::string_view word) {
    if (found) {
      field = static_cast<std::remove_reference_t<decltype(field)>>(*found);
    } else {
      wrong(wanted, word);
    }
  }
  modbus::Bytes hex() {
    const std::string_view word = next("hexadecimal bytes");
    storage_.clear();
    for (std::size_t at = 0; at < word.size(); at += 2) {
      const std::string_view digits = word.substr(at, 2);
      if (digits.size() < 2 || digits.find_first_not_of(kDigits) != digits.npos) {
        wrong("hexadecimal bytes", word);
        break;
      }
      storage_.push_back(*integer_in<std::uint8_t>(digits, 16));
    }
    return storage_;
  }
  /// Bytes of UTF-8.
  std::string text() {
    const modbus::Bytes bytes = hex();
    return {bytes.begin(), bytes.end()};
  }

  std::string_view rest_;
  std::vector<std::uint8_t>& storage_;
  bool ended_ = false;
  std::string error_;
};

}  // namespace

void append_line(std::string& out, const Input& input, Instant at) {
  if (const auto* changed = std::get_if<SettingsChanged>(&input)) {
    out += changed->config;
  }
  append_number(out, at.time_since_epoch().count());
  const auto* lost = std::get_if<LineLost>(&input);
  const bool is_closed = lost != nullptr && lost->loss == bus::Loss::closed;
  LineWriter line{out};
  line.word(kInputWords.at(is_closed ? kInputs : input.index()));
  std::visit([&](const auto& it) { visit_fields(line, it); }, input);
  out += '\n';
}

void append_line(std::string& out, const Action& action, const Settings& settings) {
  out += '<';
  LineWriter line{out};
  line.word(kActionWords.at(action.index()));
  std::visit([&](const auto& it) { visit_fields(line, it); }, action);
  if (const auto* report = std::get_if<Report>(&action)) {
    line.word(to_text(report->event, settings));
  }
  out += '\n';
}

Result<RecordedInput, std::string> parse_line(std::string_view line,
                                              std::vector<std::uint8_t>& storage) {
  LineReader reader(line, storage);
  std::int64_t nanoseconds = 0;
  reader.number(nanoseconds, "an instant in nanoseconds");
  RecordedInput recorded{Instant(Duration(nanoseconds)), LineLost{{}, bus::Loss::closed}};
  if (const auto kind = reader.choice(kInputWords, "an input"); kind < kInputs) {
    [&]<std::size_t... Kinds>(std::index_sequence<Kinds...>) {
      static_cast<void>(((Kinds == kind && (recorded.input.emplace<Kinds>(), true)) || ...));
    }
    (std::make_index_sequence<kInputs>());
  }
  std::visit([&](auto& it) { visit_fields(reader, it); }, recorded.input);
  std::string error = reader.error();
  if (!error.empty()) {
    return error;
  }
  return recorded;
}

}  // namespace mbgate::report
