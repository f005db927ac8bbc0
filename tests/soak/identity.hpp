// SPDX-License-Identifier: Apache-2.0
// Answers that show input registers in another form than registers: who the device is, its
// counters, a record of a file, a queue. By them it can be told of whom, and when, each was asked.
#pragma once

#include <functional>

#include "soak/specification.hpp"

namespace mbgate::soak {

/// 07, 11, 12, 17, 20, 24 or 43/14.
bool asks_identity(spec::Bytes request);
/// The request's answer if it shows so many input registers. `word` gives each of them, by its
/// address and the place in the answer at which it will stand.
spec::Octets identity_answer(spec::Bytes request, unsigned count,
                             const std::function<unsigned(unsigned, std::size_t)>& word);
/// How many registers the answer shows where the device is not free: otherwise `otherwise`.
unsigned shown_by(spec::Bytes request, unsigned otherwise);

}  // namespace mbgate::soak
