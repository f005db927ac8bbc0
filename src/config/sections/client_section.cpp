// SPDX-License-Identifier: Apache-2.0
// [[client]]: the clients that get more turns than others.
#include "config/sections/sections.hpp"

namespace mbgate::config {
namespace {

/// The first entry that fits a client counts: one within an earlier one would never.
void check_reached(const Draft& draft, std::vector<TomlTable>& tables,
                   const routing::Network& network) {
  const auto& all = draft.settings.weights;
  const auto wider =
      std::ranges::find_if(all, [&](const auto& other) { return other.network.contains(network); });
  if (wider == all.end()) {
    return;
  }
  const auto first = static_cast<std::size_t>(wider - all.begin());
  const auto text = tables.back().string("address").value_or("");
  if (network.contains(wider->network)) {
    report_twice(tables, first, "address", text);
    return;
  }
  tables.back().error("address",
                      in_quotes(text) + " lies in the block at " +
                          place(draft.document, tables[first].value_position("address")) +
                          ", and the first that fits counts: the narrower one must come first");
}

}  // namespace

void read_clients(Draft& draft) {
  std::vector<TomlTable> tables;  // beside settings.weights
  for (auto table : draft.document.root().tables("client")) {
    table.require("address");
    table.require("weight");
    const auto text = table.string("address");
    const auto weight = table.integer("weight", {1, 100});
    const auto network =
        text ? read_network(table, "address", *table.value("address")) : std::nullopt;
    if (network) {
      tables.push_back(table);
      check_reached(draft, tables, *network);
      draft.settings.weights.push_back({*network, static_cast<unsigned>(weight.value_or(1))});
    }
  }
}

}  // namespace mbgate::config
