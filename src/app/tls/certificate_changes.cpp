// SPDX-License-Identifier: Apache-2.0
#include "app/tls/certificate_changes.hpp"

namespace mbgate::app {
namespace {

void add_change(std::string& all, const char* key, const std::string& old,
                const std::string& next) {
  if (old != next) {
    all += (all.empty() ? "" : ", ") + std::string(key) + " " + old + " -> " + next;
  }
}

}  // namespace

std::vector<std::string> certificate_changes(const io::TlsContexts& old,
                                             const io::TlsContexts& next) {
  std::vector<std::string> changes;
  for (const auto& [name, context] : next) {
    const auto known = old.find(name);
    if (known == old.end()) {
      continue;
    }
    const io::TlsContents& before = known->second->contents();
    const io::TlsContents& after = context->contents();
    std::string all;
    add_change(all, "certificate", before.certificate, after.certificate);
    add_change(all, "authorities", before.authorities, after.authorities);
    add_change(all, "crl", before.lists, after.lists);
    if (!all.empty()) {
      changes.push_back("[[tls]] " + name + ": " + all);
    }
  }
  return changes;
}

}  // namespace mbgate::app
