// SPDX-License-Identifier: Apache-2.0
#include "app/who/who_options.hpp"

#include <array>
#include <fmt/core.h>
#include <vector>

#include "config/toml/match_entry.hpp"
#include "gateway/access/who.hpp"
#include "modbus/request.hpp"

namespace mbgate::app {
namespace {

using modbus::Request;
using modbus::Table;
using modbus::TableRange;

constexpr std::string_view kUsage =
    "expected --read or --write, each with a table and an address, such as --write holding 124";

Result<TableRange, std::string> asked_range(const WhoOptions& options) {
  const auto& words = options.read.empty() ? options.write : options.read;
  if (words.size() != 2 || options.read.empty() == options.write.empty()) {
    return std::string(kUsage);
  }
  const auto table = config::value_of(config::kTables, words[0]);
  const auto address = config::parse_register_address(words[1]);
  if (!table || !address) {
    return std::string(kUsage);
  }
  if (options.count == 0 || *address + options.count > 0x10000U) {
    return "--count: expected 1 or more, and no address beyond 65535";
  }
  return TableRange{*table, *address, static_cast<std::uint16_t>(options.count)};
}

Result<modbus::Pdu, std::string> asked_request(const WhoOptions& options) {
  const auto range = asked_range(options);
  if (!range) {
    return range.error();
  }
  const auto& [table, first, count] = *range;
  const bool reads = !options.read.empty();
  if (!reads && (table == Table::discrete_inputs || table == Table::input_registers)) {
    return "--write: expected a table that can be written, coils or holding";
  }
  const drive::Limits limits;
  const auto most = reads ? limits.read_from(table) : limits.written_to(table);
  if (count > most) {
    return fmt::format("--count: expected at most {}", most);
  }
  if (reads) {
    return modbus::make_read(*range).pdu();
  }
  const bool bits = modbus::holds_bits(table);
  if (options.value > (bits ? 1U : 0xFFFFU)) {
    return std::string(bits ? "--value: expected 0 or 1" : "--value: expected 0 to 65535");
  }
  const std::vector<std::uint16_t> values(count, static_cast<std::uint16_t>(options.value));
  return modbus::make_write(table, first, values).pdu();
}

std::string client_text(const WhoOptions& options, const routing::ClientRole& role) {
  if (role.kind == routing::ClientRole::Kind::none) {
    return options.client;
  }
  return fmt::format(
      "{}{}{}", options.client,
      role.certificate.empty() ? "" : fmt::format(" with certificate \"{}\"", role.certificate),
      role.name.empty() ? " with the NULL role" : fmt::format(" as role \"{}\"", role.name));
}

std::string asked_text(const WhoOptions& options, const std::string& client,
                       const std::string& listener, const modbus::Pdu& pdu) {
  const bool reads = !options.read.empty();
  const auto& words = reads ? options.read : options.write;
  return fmt::format("{} on {}: {}{} {}{} of unit {} (function {}): ", client, listener,
                     reads ? "read " : "write ", words[0], words[1],
                     options.count > 1 ? fmt::format(" and {} more", options.count - 1) : "",
                     options.unit, pdu.function());
}

// Where the key stands that has denied it, if that is known.
std::string place_text(const config::KeyPlaces& places, const gateway::DenyingKey& key) {
  using enum gateway::DenyingKey::Name;
  using config::Word;
  constexpr std::array kWords = {Word{"allow", allow},     Word{"read_only", read_only},
                                 Word{"access", access},   Word{"functions", functions},
                                 Word{"windows", windows}, Word{"writer", writer}};
  const auto place = places.find({word_for(kWords, key.name), key.entry});
  return place == places.end() ? "" : fmt::format(" ({})", place->second);
}

std::string answer_text(const gateway::WhoAnswer& answer, const config::KeyPlaces& places) {
  return fmt::format("{}{}{}", answer.by, answer.key ? place_text(places, *answer.key) : "",
                     answer.consequence);
}

// A client has a role where there is TLS, and nowhere else.
routing::ClientRole asked_role(const WhoOptions& options,
                               const gateway::ListenerSettings& listener) {
  return listener.tls ? routing::ClientRole{routing::ClientRole::Kind::named,
                                            options.role.value_or(""), options.certificate}
                      : routing::ClientRole{};
}

}  // namespace

Result<WhoAnswers, std::string> answer_who(const gateway::Settings& settings,
                                           const config::KeyPlaces& places,
                                           const WhoOptions& options) {
  const auto address = routing::ClientAddress::parse(options.client);
  if (!address) {
    return std::string("--who: expected an IPv4 or IPv6 address, such as 192.168.10.5");
  }
  if (options.unit > 255) {
    return std::string("--unit: expected 0 to 255");
  }
  const auto request = asked_request(options);
  if (!request) {
    return request.error();
  }
  WhoAnswers answers;
  const gateway::SettingsSnapshot snapshot(settings);
  for (std::size_t listener = 0; listener < settings.listeners.size(); ++listener) {
    const gateway::ListenerSettings& where = settings.listeners[listener];
    const std::string& name = where.name;
    if (options.listener && name != *options.listener) {
      continue;
    }
    gateway::ClientInfo client{routing::ListenerId{static_cast<std::uint32_t>(listener)}, *address};
    client.role = asked_role(options, where);
    const auto answer =
        gateway::who_may(snapshot, client, static_cast<std::uint8_t>(options.unit), *request);
    answers.any_permitted = answers.any_permitted || answer.permitted;
    answers.text += asked_text(options, client_text(options, client.role), name, *request) +
                    answer_text(answer, places) + '\n';
  }
  if (answers.text.empty()) {
    return fmt::format("--listener: no [[listen]] is named \"{}\"", options.listener.value_or(""));
  }
  return answers;
}

}  // namespace mbgate::app
