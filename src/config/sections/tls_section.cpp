// SPDX-License-Identifier: Apache-2.0
// Certificates, and keys that another process holds. Whether the files are there and fit is seen
// when they are needed: a configuration is read on other machines too.
#include <filesystem>

#include "config/sections/sections.hpp"

namespace mbgate::config {
namespace {

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

void read_tls(Draft& draft) {
  for (auto table : draft.document.root().tables("tls")) {
    TlsSettings tls;
    draft.tls.push_back(table);
    tls.name = read_name(table);
    check_name(draft.tls, draft.settings.tls, tls.name);
    for (const auto* key : {"certificate", "key", "authorities"}) {
      table.require(key);
    }
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
