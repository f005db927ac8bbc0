// SPDX-License-Identifier: Apache-2.0
// The reading of a recording. The text comes from outside: every line is checked whole.
#include <fmt/core.h>
#include <optional>

#include "base/text.hpp"
#include "gateway/limits.hpp"
#include "gateway/recording/record.hpp"

namespace mbgate::gateway {
namespace {

std::optional<unsigned> digit_of(char character) {
  constexpr std::string_view kDigits = "0123456789ABCDEF";
  const std::size_t digit = kDigits.find(character);
  return digit == std::string_view::npos ? std::nullopt
                                         : std::optional(static_cast<unsigned>(digit));
}

/// Takes the words of a line one by one, each after one space; the first wrong one is kept as the
/// error.
class LineWords {
 public:
  explicit LineWords(std::string_view line) : rest_(line) {}

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
  Number number(std::string_view wanted) {
    const std::string_view word = next(wanted);
    const auto value = integer_in<Number>(word);
    if (!value) {
      wrong(wanted, word);
    }
    return value.value_or(Number{});
  }
  ClientId client() { return ClientId{number<std::uint64_t>("the number of a client")}; }
  BusId bus() { return BusId{number<std::uint32_t>("the place of a bus")}; }
  routing::ClientAddress address() {
    const std::string_view word = next("an address");
    const auto value = routing::ClientAddress::parse(word);
    if (!value) {
      wrong("an address", word);
    }
    return value.value_or(routing::ClientAddress{});
  }
  bus::LineKind line_kind() {
    const std::string_view word = next("uart, adapter or virtual");
    if (word == "uart") {
      return bus::LineKind::uart;
    }
    if (word == "adapter") {
      return bus::LineKind::adapter;
    }
    if (word != "virtual") {
      wrong("uart, adapter or virtual", word);
    }
    return bus::LineKind::virtual_line;
  }
  modbus::Bytes hex(std::vector<std::uint8_t>& storage) {
    const std::string_view word = next("hexadecimal bytes");
    storage.clear();
    for (std::size_t at = 0; at < word.size(); at += 2) {
      const auto high = digit_of(word[at]);
      const auto low = at + 1 < word.size() ? digit_of(word[at + 1]) : std::nullopt;
      if (!high || !low) {
        wrong("hexadecimal bytes", word);
        break;
      }
      storage.push_back(static_cast<std::uint8_t>(*high * 16 + *low));
    }
    return storage;
  }
  /// What may follow at the end of the line.
  routing::ClientRole role() {
    using Kind = routing::ClientRole::Kind;
    if (ended_) {
      return {};
    }
    routing::ClientRole role{Kind::unreadable};
    const std::string_view word = next("role or no-role");
    if (word == "role") {
      role = {Kind::named, text()};
    } else if (word != "no-role") {
      wrong("role or no-role", word);
      return {};
    }
    if (!ended_) {
      const std::string_view more = next("certificate");
      if (more == "certificate") {
        role.certificate = text();
      } else {
        wrong("certificate", more);
      }
    }
    return role;
  }
  /// Bytes of UTF-8.
  std::string text() {
    std::vector<std::uint8_t> bytes;
    hex(bytes);
    return {bytes.begin(), bytes.end()};
  }
  void wrong(std::string_view wanted, std::string_view found) {
    if (error_.empty()) {
      error_ = fmt::format("expected {}, found \"{}\"", wanted, found);
    }
  }
  [[nodiscard]] bool has_ended() const { return ended_; }
  /// What was wrong, or nothing if the line ends here.
  std::string error() {
    if (!ended_) {
      wrong("the end of the line", rest_);
    }
    return error_;
  }

 private:
  std::string_view rest_;
  bool ended_ = false;
  std::string error_;
};

Instant instant_of(std::int64_t nanoseconds) { return Instant(Duration(nanoseconds)); }

ClientConnected connected_of(LineWords& words) {
  ClientConnected input{words.client(), {}};
  input.info.listener = ListenerId{words.number<std::uint32_t>("the place of a listener")};
  input.info.address = words.address();
  if (const auto since = words.number<std::int64_t>("an instant in nanoseconds"); since > 0) {
    input.info.waits_since = instant_of(since);
  }
  input.info.role = words.role();
  return input;
}

modbus::Bytes read_bytes(LineWords& words, std::vector<std::uint8_t>& storage) {
  const modbus::Bytes bytes = words.hex(storage);
  if (bytes.size() > kClientReadSize) {
    words.wrong(fmt::format("at most {} bytes", kClientReadSize),
                fmt::format("{} bytes", bytes.size()));
  }
  return bytes;
}

ClientBytes bytes_of(LineWords& words, std::vector<std::uint8_t>& storage) {
  ClientBytes input{words.client(), {}, words.number<std::size_t>("a number of bytes")};
  input.bytes = read_bytes(words, storage);
  return input;
}

ClientDisconnected gone_of(LineWords& words, std::vector<std::uint8_t>& storage) {
  ClientDisconnected input{words.client()};
  if (!words.has_ended()) {
    input.bytes = read_bytes(words, storage);
  }
  return input;
}

Stalled stalled_of(LineWords& words) {
  return {std::chrono::milliseconds(words.number<std::uint32_t>("a number of milliseconds"))};
}

Input input_of(LineWords& words, std::vector<std::uint8_t>& storage) {
  const std::string_view kind = words.next("an input");
  if (kind == "connected") {
    return connected_of(words);
  }
  if (kind == "read") {
    return bytes_of(words, storage);
  }
  if (kind == "sent") {
    return ClientSent{words.client()};
  }
  if (kind == "fin") {
    return ClientHalfClosed{words.client()};
  }
  if (kind == "gone") {
    return gone_of(words, storage);
  }
  if (kind == "opened") {
    const BusId bus = words.bus();
    return LineOpened{bus, words.line_kind()};
  }
  if (kind == "line") {
    const BusId bus = words.bus();
    return LineBytes{bus, words.hex(storage)};
  }
  if (kind == "unsent") {
    const BusId bus = words.bus();
    return LineUnsent{bus, words.number<std::size_t>("a number of bytes")};
  }
  if (kind == "lost") {
    return LineLost{words.bus()};
  }
  if (kind == "closed") {
    return LineLost{words.bus(), bus::Loss::closed};
  }
  if (kind == "looked") {
    return LineLooked{words.bus()};
  }
  if (kind == "settings") {
    return SettingsChanged{};
  }
  if (kind == "stalled") {
    return stalled_of(words);
  }
  if (kind == "clear") {
    return ClearCountersAsked{};
  }
  if (kind == "shutdown") {
    return ShutdownAsked{};
  }
  if (kind != "time") {
    words.wrong("an input", kind);
  }
  return DeadlineReached{};
}

/// Takes `key` and a space off the front of the line.
bool take_key(std::string_view& line, std::string_view key) {
  if (!line.starts_with(key) || line.size() <= key.size() || line[key.size()] != ' ') {
    return false;
  }
  line.remove_prefix(key.size() + 1);
  return true;
}

}  // namespace

bool ConfigReader::read(std::string_view line) {
  if (take_key(line, "config")) {
    files_.push_back({std::string(line), {}});
    return true;
  }
  if (files_.empty() || !take_key(line, "|")) {
    return false;
  }
  (files_.back().text += line) += '\n';
  return true;
}

Result<RecordedInput, std::string> parse_line(std::string_view line,
                                              std::vector<std::uint8_t>& storage) {
  LineWords words(line);
  const Instant at = instant_of(words.number<std::int64_t>("an instant in nanoseconds"));
  RecordedInput recorded{at, input_of(words, storage)};
  std::string error = words.error();
  if (!error.empty()) {
    return error;
  }
  return recorded;
}

Result<bool, std::string> HeadReader::read(std::string_view line) {
  if (!begun_) {
    begun_ = line == "mbgate recording 1";
    return begun_ ? Result<bool, std::string>(false)
                  : std::string("expected \"mbgate recording 1\": this is not a recording");
  }
  if (config_.read(line)) {
    return false;
  }
  std::string_view value = line;
  if (take_key(value, "version")) {
    head_.version = value;
  } else if (take_key(value, "profiles")) {
    head_.profiles = value;
  } else if (line.ends_with(" start")) {
    const auto start = integer_in<std::int64_t>(line.substr(0, line.size() - 6));
    head_.config = config_.take();
    if (!start || head_.config.empty()) {
      return std::string(start ? "expected the configuration before the start"
                               : "expected an instant in nanoseconds before \"start\"");
    }
    head_.start = instant_of(*start);
    return true;
  } else {
    return fmt::format("expected a line of the configuration or the start, found \"{}\"", line);
  }
  return false;
}

}  // namespace mbgate::gateway
