// SPDX-License-Identifier: Apache-2.0
// [http]: the Unix socket of the HTTP interface, and the TCP addresses where it only reads.
#include <cctype>
#include <filesystem>

#include "config/sections/sections.hpp"

namespace mbgate::config {
namespace {

using gateway::HttpSettings;
using gateway::ListenerSettings;
using routing::ListenAddress;

/// Of a name (RFC 1035, 2.3.4).
constexpr std::size_t kLongestHost = 253;

constexpr std::string_view kListen =
    R"(an IPv4 or IPv6 address and a port, such as "127.0.0.1:8080" or "[::1]:8080")";

/// One text, or a list of texts.
std::vector<TomlText> listen_texts(TomlTable& table) {
  const auto* found = table.value("listen");
  if (found == nullptr) {
    return {};
  }
  if (const auto* text = std::get_if<std::string>(&found->data)) {
    return {{*text, found->position}};
  }
  if (!std::holds_alternative<std::vector<TomlValue>>(found->data)) {
    table.report_expected("listen", *found, "{}, or a list of such", kListen);
    return {};
  }
  return table.strings("listen").value_or(std::vector<TomlText>());
}

ListenerSettings as_listener(const ListenAddress& listen) {
  ListenerSettings listener;
  listener.address = listen.address.to_text();
  listener.port = listen.port;
  return listener;
}

/// Where that has taken the port; `entries` are those before this one.
std::optional<Position> taken_at(const Draft& draft, const std::vector<TomlText>& entries,
                                 const ListenAddress& listen) {
  const auto wanted = as_listener(listen);
  const auto& listeners = draft.settings.listeners;
  const auto listener =
      std::ranges::find_if(listeners, [&](const auto& it) { return clash(it, wanted); });
  if (listener != listeners.end()) {
    return draft.listeners[static_cast<std::size_t>(listener - listeners.begin())].value_position(
        "port");
  }
  const auto& own = draft.settings.http.listen;
  const auto same =
      std::ranges::find_if(own, [&](const auto& it) { return clash(as_listener(it), wanted); });
  return same == own.end()
             ? std::nullopt
             : std::optional(entries[static_cast<std::size_t>(same - own.begin())].position);
}

/// One line must not show what drives do to every network of the machine.
void read_listen(Draft& draft, TomlTable& table) {
  std::vector<TomlText> entries;  // beside settings.http.listen
  for (const auto& [text, position] : listen_texts(table)) {
    const auto listen = ListenAddress::parse(text);
    if (!listen) {
      table.report_expected("listen", {position, text}, kListen);
      continue;
    }
    if (routing::is_link_local(listen->address)) {
      draft.document.error(position, fmt::format("listen: {}", kNoScope));
    }
    if (const auto first = taken_at(draft, entries, *listen)) {
      draft.document.error(position, "listen: the port of {} is already used at {}",
                           in_quotes(text), place(draft.document, *first));
    }
    if (!is_loopback(listen->address) && !table.has("allow")) {
      draft.document.error(position,
                           "listen: other machines can reach {}: expected 'allow' with the "
                           "permitted clients, such as allow = [\"192.168.10.0/24\"]",
                           in_quotes(text));
    }
    draft.settings.http.listen.push_back(*listen);
    entries.push_back({text, position});
  }
}

void read_allow(TomlTable& table, HttpSettings& http) {
  const auto* allowed = table.value("allow");
  if (allowed == nullptr) {
    return;
  }
  http.allow = read_networks(table, "allow");
  if (is_empty_list(*allowed)) {
    table.error("allow", "expected at least one address; leave the key out for this machine alone");
  }
}

bool is_host(std::string_view text) {
  return !text.empty() && text.size() <= kLongestHost && std::ranges::all_of(text, [](char letter) {
    return std::isalnum(static_cast<unsigned char>(letter)) != 0 || letter == '-' ||
           letter == '.' || letter == '_';
  });
}

void read_hosts(TomlTable& table, HttpSettings& http) {
  for (auto& [text, position] : table.strings("hosts").value_or(std::vector<TomlText>())) {
    if (!is_host(text)) {
      table.report_expected("hosts", {position, text},
                            "a host name as in a URL, without port, such as "
                            "\"gateway.plant\"");
      continue;
    }
    std::string host;
    for (const char letter : text) {
      host += static_cast<char>(std::tolower(static_cast<unsigned char>(letter)));
    }
    http.hosts.push_back(std::move(host));
  }
}

using gateway::TlsSettings;

/// Relative to the folder of the file of the configuration.
void read_certificates(TomlTable& table, std::string_view key, std::string& path) {
  const auto named = table.string(key);
  if (!named) {
    return;
  }
  if (named->empty()) {
    table.report_expected(key, *table.value(key), "the path of a file in PEM form");
    return;
  }
  const Position position = table.value_position(key);
  path = (std::filesystem::path(table.document().name(position)).parent_path() / *named)
             .lexically_normal()
             .string();
}

void read_private_key(TomlTable& table, TlsSettings& tls) {
  const auto key = table.string("key");
  if (!key) {
    return;
  }
  if (key->empty() || key->find('/') != std::string::npos || key->starts_with('.') ||
      key->size() > gateway::kLongestKeyName) {
    table.report_expected("key", *table.value("key"),
                          "the name of a file in the folder of mbgate-signer (/etc/mbgate/tls), "
                          "without '/' and with no '.' in front");
  }
  tls.key = *key;
}

}  // namespace

void read_http(Draft& draft) {
  auto table = draft.document.root().table("http");
  if (!table) {
    return;
  }
  read_socket_path(*table, "socket", draft.settings.control_socket, ", or \"\" for none");
  read_listen(draft, *table);
  read_allow(*table, draft.settings.http);
  read_hosts(*table, draft.settings.http);
  read_keys(*table, http_keys(), draft.settings.http);
}

void read_tls(Draft& draft) {
  for (auto table : draft.document.root().tables("tls")) {
    TlsSettings tls;
    draft.tls.push_back(table);
    tls.name = read_name(draft.tls, draft.settings.tls);
    table.require_all({"certificate", "key", "authorities"});
    read_certificates(table, "certificate", tls.certificate);
    read_private_key(table, tls);
    read_certificates(table, "authorities", tls.authorities);
    read_certificates(table, "crl", tls.crl);
    // After an error it may be the smaller worry.
    if (tls.crl.empty() && !draft.document.failed()) {
      draft.document.warning(table.position(),
                             "[[tls]]: without crl a certificate that was lost or stolen is "
                             "accepted until it expires: name a list of revoked certificates "
                             "(mbgate-cert ca makes an empty one)");
    }
    draft.settings.tls.push_back(std::move(tls));
  }
}

}  // namespace mbgate::config
