// SPDX-License-Identifier: Apache-2.0
// A plain key: its value is true or false, a number, or a length of time within a range, and that
// is all there is to say of it. What needs more is read by its section.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <type_traits>
#include <variant>

#include "config/toml/toml_reader.hpp"

namespace mbgate::config {

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
  Lines lines = Lines::any;      ///< where it has a meaning
  std::string_view elsewhere{};  ///< what is said of it where it has none
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

/// The range of the key makes sure that the value fits the target. Only an optional one takes
/// nothing.
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

/// The key of the member at the end of the path, which begins in the section:
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

/// The value in the table; nothing if it is absent or wrong, which has been reported then.
KeyValue read_key(TomlTable& table, std::string_view key, const KeyRange& range);

/// Takes over what the table says. A key that belongs to none of `lines`, what the bus may be, is
/// reported.
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

}  // namespace mbgate::config
