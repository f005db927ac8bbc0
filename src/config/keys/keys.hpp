// SPDX-License-Identifier: Apache-2.0
// The plain keys of each section. These tables determine how the keys are read, what is said of a
// wrong type, a wrong range or a wrong kind of line, `mbgated --keys` and mbgate.toml(5).
// conf/mbgate.toml explains the keys.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <variant>

#include "config/toml/toml_reader.hpp"
#include "gateway/settings.hpp"

namespace mbgate::config {

// A plain key: its value is true or false, or a number or a duration within a range, and nothing
// else has to be checked. Other keys are read by their section.

/// What may be at the far end of a bus. A set, since a key may belong to several.
enum class Lines : std::uint8_t {
  port_rtu = 1,      ///< a serial port of this machine
  port_ascii = 2,    ///< the same in ASCII
  remote_rtu = 4,    ///< a serial device server
  remote_ascii = 8,  ///< the same in ASCII
  server = 16,       ///< a Modbus TCP server
  ports = port_rtu | port_ascii,
  serial = ports | remote_rtu | remote_ascii,
  rtu = port_rtu | remote_rtu,
  connections = remote_rtu | remote_ascii | server,
  any = serial | server,
};
constexpr bool have_common(Lines a, Lines b) {
  return (static_cast<unsigned>(a) & static_cast<unsigned>(b)) != 0;
}

/// True or false.
struct Truth {};
using KeyRange = std::variant<Truth, IntegerRange, DurationRange>;
/// Nothing: not set, because the default depends on other keys.
using KeyValue = std::variant<std::monostate, bool, std::int64_t, std::chrono::nanoseconds>;

template <typename Section>
struct PlainKey {
  std::string_view name;
  KeyRange range;
  KeyValue (*get)(const Section&);
  void (*set)(Section&, const KeyValue&);
  Lines lines = Lines::any;      ///< where the key has a meaning
  std::string_view elsewhere{};  ///< the error text where it has none
};

template <typename Member>
struct MemberOf;
template <typename Owner, typename Value>
struct MemberOf<Value Owner::*> {
  using Section = Owner;
};

template <auto Member, auto... Rest>
constexpr auto& follow(auto& object) {
  if constexpr (sizeof...(Rest) == 0) {
    return object.*Member;
  } else {
    return follow<Rest...>(object.*Member);
  }
}

template <typename Value>
struct IsOptional : std::false_type {};
template <typename Value>
struct IsOptional<std::optional<Value>> : std::true_type {};

template <typename Target>
KeyValue key_value(const Target& target) {
  if constexpr (IsOptional<Target>::value) {
    return target ? key_value(*target) : KeyValue();
  } else if constexpr (std::is_same_v<Target, bool>) {
    return target;
  } else if constexpr (std::is_integral_v<Target> || std::is_enum_v<Target>) {
    return static_cast<std::int64_t>(target);
  } else {
    return std::chrono::nanoseconds(target);
  }
}

/// The range of the key ensures that the value fits the target. Only an optional target takes an
/// empty value.
template <typename Target>
void set_from(Target& target, const KeyValue& value) {
  if constexpr (IsOptional<Target>::value) {
    if (std::holds_alternative<std::monostate>(value)) {
      target.reset();
    } else {
      set_from(target.emplace(), value);
    }
  } else if constexpr (std::is_same_v<Target, bool>) {
    target = std::get<bool>(value);
  } else if constexpr (std::is_integral_v<Target> || std::is_enum_v<Target>) {
    target = static_cast<Target>(std::get<std::int64_t>(value));
  } else {
    target = std::chrono::duration_cast<Target>(std::get<std::chrono::nanoseconds>(value));
  }
}

/// The key for the member at the end of a path that begins in the section:
/// plain<&BusSettings::line, &LineSettings::low_latency>("low_latency", Truth{}).
template <auto First, auto... Rest>
constexpr auto plain(std::string_view name, KeyRange range, Lines lines = Lines::any,
                     std::string_view elsewhere = {}) {
  using Section = typename MemberOf<decltype(First)>::Section;
  return PlainKey<Section>{
      name,
      range,
      [](const Section& section) { return key_value(follow<First, Rest...>(section)); },
      [](Section& section, const KeyValue& value) {
        set_from(follow<First, Rest...>(section), value);
      },
      lines,
      elsewhere};
}

/// The value in the table. Nothing if it is absent, or wrong; a wrong value is reported.
KeyValue read_key(TomlTable& table, std::string_view key, const KeyRange& range);

/// Takes the values of the table over. `lines`: what the bus may be. A key that has no meaning for
/// it is reported.
template <typename Section>
void read_keys(TomlTable& table, std::span<const PlainKey<Section>> keys,
               std::type_identity_t<Section>& section, Lines lines = Lines::any) {
  for (const auto& key : keys) {
    if (!have_common(key.lines, lines)) {
      if (table.has(key.name)) {
        table.error(key.name, key.elsewhere);
      }
      continue;
    }
    const KeyValue value = read_key(table, key.name, key.range);
    if (!std::holds_alternative<std::monostate>(value)) {
      key.set(section, value);
    }
  }
}

/// [gateway]
std::span<const PlainKey<gateway::Settings>> gateway_keys();
/// [http]
std::span<const PlainKey<gateway::HttpSettings>> http_keys();
/// [[listen]]
std::span<const PlainKey<gateway::ListenerSettings>> listener_keys();
/// [[bus]]
std::span<const PlainKey<bus::BusSettings>> bus_keys();
/// [[bus]] and [[device]]
std::span<const PlainKey<drive::DeviceTiming>> timing_keys();
/// [[device]]
std::span<const PlainKey<drive::Device>> device_keys();
/// [[device]]
std::span<const PlainKey<gateway::DeviceGuard>> guard_keys();

/// What the bus is connected to; `any` if the settings do not tell.
Lines lines_of(const bus::LineSettings& settings);

/// The value as it would be written in the file; "-" for none.
std::string value_text(const KeyValue& value);

/// A line for each plain key: section, key, what it takes, its default and where it belongs,
/// separated by tabs. A default that depends on other keys is "-".
std::string list_keys();

}  // namespace mbgate::config
