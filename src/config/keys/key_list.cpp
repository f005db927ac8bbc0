// SPDX-License-Identifier: Apache-2.0
#include "config/keys/keys.hpp"
#include "config/toml/duration_text.hpp"

namespace mbgate::config {
namespace {

struct RangeToText {
  std::string operator()(Truth /*none*/) const { return "true or false"; }
  std::string operator()(const auto& range) const { return range_text(range); }
};

struct ToText {
  std::string operator()(std::monostate /*none*/) const { return "-"; }
  std::string operator()(bool truth) const { return truth ? "true" : "false"; }
  std::string operator()(std::int64_t number) const { return std::to_string(number); }
  std::string operator()(std::chrono::nanoseconds duration) const {
    return in_quotes(to_text(duration));
  }
};

std::string_view place_of(Lines lines) {
  switch (lines) {
    case Lines::any: return "everywhere";
    case Lines::serial: return "serial lines";
    case Lines::ports: return "serial ports of this machine";
    case Lines::rtu: return "mode = \"rtu\"";
    case Lines::connections: return "TCP connections";
    case Lines::server: return "mode = \"tcp\"";
    case Lines::port_rtu:
    case Lines::port_ascii:
    case Lines::remote_rtu:
    case Lines::remote_ascii: break;
  }
  return {};
}

template <typename Section>
void list(std::string& text, std::string_view title, std::span<const PlainKey<Section>> keys,
          const std::type_identity_t<Section>& defaults) {
  for (const auto& key : keys) {
    text += title;
    text += '\t';
    text += key.name;
    text +=
        '\t' + std::visit(RangeToText(), key.range) + '\t' + value_text(key.get(defaults)) + '\t';
    text += place_of(key.lines);
    text += '\n';
  }
}

}  // namespace

std::string value_text(const KeyValue& value) { return std::visit(ToText(), value); }

std::string list_keys() {
  std::string text;
  list(text, "[gateway]", gateway_keys(), {});
  list(text, "[http]", http_keys(), {});
  list(text, "[[listen]]", listener_keys(), {});
  list(text, "[[bus]]", bus_keys(), {});
  list(text, "[[bus]]", timing_keys(), {});
  list(text, "[[device]]", timing_keys(), {});
  list(text, "[[device]]", device_keys(), {});
  list(text, "[[device]]", guard_keys(), {});
  return text;
}

}  // namespace mbgate::config
