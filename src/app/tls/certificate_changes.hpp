// SPDX-License-Identifier: Apache-2.0
// What a reload changes by reading files of a [[tls]] anew whose names are the same, for the
// journal.
#pragma once

#include <string>
#include <vector>

#include "io/tls/load_tls.hpp"

namespace mbgate::app {

/// A line for each [[tls]] that is in both: "[[tls]] plant: crl 2026-11-27 ..., 2 revoked, 1A:...
/// -> 2026-11-28 ..., 3 revoked, 9F:...". Those of one alone are told with their listeners.
std::vector<std::string> certificate_changes(const io::TlsContexts& old,
                                             const io::TlsContexts& next);

}  // namespace mbgate::app
