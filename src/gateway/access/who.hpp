// SPDX-License-Identifier: Apache-2.0
// `mbgated --check --who`: whether a request of a client would be permitted, and what decides. It
// asks the same parts as the gateway, in the same order.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "gateway/client.hpp"
#include "gateway/settings/settings_snapshot.hpp"
#include "modbus/pdu.hpp"

namespace mbgate::gateway {

/// A key of the configuration that denies, and of which listener, route or device: its place in the
/// settings.
struct DenyingKey {
  enum class Name : std::uint8_t { allow, read_only, access, functions, windows, writer };
  Name name;
  std::size_t entry;
};

struct WhoAnswer {
  bool permitted = false;
  /// `permitted by rule "panel" (mbgate.toml:12)`, `denied by read_only of listener plant`: the
  /// first that denies it, or the rule that permits it.
  std::string by;
  std::string consequence{};        ///< `: exception 01`
  std::optional<DenyingKey> key{};  ///< that `by` names; where it stands belongs behind it

  [[nodiscard]] std::string text() const { return by + consequence; }
};

[[nodiscard]] WhoAnswer who_may(const SettingsSnapshot& settings, const ClientInfo& client,
                                std::uint8_t unit, const modbus::Pdu& request);

}  // namespace mbgate::gateway
