// SPDX-License-Identifier: Apache-2.0
// What is fast enough, in plants that are made for it, at the product's default times: figures,
// each with the bound that the contract wants, and whether today's gateway keeps it.
#pragma once

namespace mbgate::judge {

/// Prints a table. False: one is out that is kept today.
bool run_bounds();

}  // namespace mbgate::judge
