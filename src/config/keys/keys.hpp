// SPDX-License-Identifier: Apache-2.0
// The plain keys of each section. These tables determine how the keys are read, what is said of a
// wrong type, a wrong range or a wrong kind of line, `mbgated --keys` and mbgate.toml(5).
// conf/mbgate.toml explains the keys.
#pragma once

#include <span>
#include <string>

#include "config/keys/plain_key.hpp"
#include "gateway/settings.hpp"

namespace mbgate::config {

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
